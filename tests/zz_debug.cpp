#include "march_cases.h"
#include "march/atlas_march.h"
namespace psivox::glslf {
using glm::abs; using glm::clamp; using glm::dot; using glm::floor; using glm::max; using glm::min; using glm::mix; using std::sqrt;
using real=float; using real2=glm::vec2; using real3=glm::vec3; using real4=glm::vec4; using int3=glm::ivec3; using uint=std::uint32_t;
struct M { const BrickAtlas* grids[2]={};
  real power_of_two(int n){return std::ldexp(1.0f,n);}
  uint fetch_page(int grid, int i) const { return grids[grid]->pages.entries[std::size_t(i)]; }
  real fetch_constant(int grid, int i) const { return grids[grid]->constants[std::size_t(i)]; }
  real3 fetch_constant3(int grid, int i) const { return {}; }
  real fetch_texel(int grid, int i) const { return grids[grid]->texels32[i]; }
  real3 fetch_texel3(int grid, int i) const { return {};}
  real filtered_texel(int, int, real3) const { return 0; }
  real3 filtered_texel3(int, int, real3) const { return real3(0); }
#include "/tmp/testwork/march_members32.h"
};
}

namespace psivox { 
glm::dmat4 tilted() {
  glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(-18, -20, -14));
  m = glm::rotate(m, 0.3, glm::dvec3(1, 2, 0.5));
  return glm::scale(m, glm::dvec3(2.3, 1.7, 1.9));
}
Field scalar_glow() {
  return make_field({{0, 0, 0}, {24, 24, 24}},
                    [](glm::ivec3 v) { return 0.3f + blobs_at(glm::dvec3(v) * 1.5); }, tilted());
}

#include "march/march_parameters.h"
template<class M> void trace(M& m, const MarchSetup& su, const char*n){
  m.configure(su);
  m.sample_offset={.5,.5}; m.stop_depth=1e30;
  auto p=m.make_pixel({47,46}); auto ray=m.density_ray(p); m.max_turns=1;
  auto s=m.begin_march(ray); 
  for(int k=0;k<400&&!s.done;k++){ s=m.march_on(s,p,ray); 
   printf("%s %3d cell %d %d %d t %.6f v %.6f L %.6f fresh %d R %.8f tau %.8f lnode %d\n",n,k,s.cell.x,s.cell.y,s.cell.z,(double)s.t,(double)s.value,(double)s.L.x,s.fresh,(double)s.radiance.x,(double)s.optical_depth,s.luminance_node.kind);}
}
TEST(D,D){
  Scene scene = looking(small_scene(64), {95,60,70}, {11,12,11});
  scene.extinction=.12; scene.luminance={1,.5,.25}; scene.segments=1;
  View v=view_of(scene,mixed(),scalar_glow());
  Atlases a(v);
  auto su=make_march_setup(v,a.density,a.own());
  glsl::AtlasMarch d; d.grids[0]=&a.density; d.grids[1]=a.own(); trace(d,su,"D");
  glslf::M f; f.grids[0]=&a.density; f.grids[1]=a.own(); trace(f,su,"F");
}
}
