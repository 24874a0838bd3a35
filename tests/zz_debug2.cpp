#include "march_cases.h"
#include "psivox/vdb.h"
namespace psivox {
TEST(E,E){
  for (const char* f : {"smoke","cloud_tiles","mri_t1","heptane","neghip"}) for (double k : {0.0, 2.0}) {
    VdbFile file(shared_data()/(std::string(f)+".vdb"));
    Scene s; s.resolution={96,96}; s.early_termination=0; 
    if(k>0) { s.extinction=k; if(std::string(f)!="smoke") continue; }
    s.luminance_grid=file.default_grid();
    for(int seg:{1,2,4}) for (auto rule:{Integrator::psi_weighted,Integrator::psi_balanced}){ s.segments=seg; s.integrator=rule; View v=make_view(s,file);
      static std::map<std::string,Image> refs; auto key=std::string(f)+std::to_string(k); if(!refs.count(key)) refs[key]=render_reference(v).image;
      auto c=compare_images(double_picture(v),refs[key]); printf("%s K %g seg %d %s: rms %.3e max %.3e\n",f,k,seg,info(rule).name,c.rms,c.max);}
  }
}}
