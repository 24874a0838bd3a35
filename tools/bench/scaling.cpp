// scaling: measures how the march's time grows with pixels, voxels, the active fraction, the
// optical depth and the tolerance, and how memory grows with active voxels. The points of a curve
// take turns in rounds; results are medians. Look-ups are counted in a separate draw.
#include <cstdint>
#include <cstdio>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "base/renderer_name.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "bench.h"
#include "gl/egl_context.h"
#include "gl/program.h"
#include "gl/tiles.h"
#include "psivox/dense_field.h"
#include "psivox/draw.h"

namespace {

using namespace psivox;
using bench::median;

constexpr int rounds = 5;

constexpr int fetch_side = 512;
constexpr int lookups = 64;  ///< per pixel

constexpr const char* shader = R"glsl(
layout(location = 0) out vec4 out_picture;
layout(location = 1) out vec4 out_layers;
uniform samplerBuffer texels;
uniform int cells;  // of whole bricks of 9^3 texels

float fetch(int at) { return texelFetch(texels, at).x; }

void main() {
  int first = int(gl_FragCoord.x) + 512 * int(gl_FragCoord.y);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < LOOKUPS; ++i) {
    int at = (first + 81 * i) % cells;  // a ray goes from slab to slab
    sum += vec4(fetch(at), fetch(at + 1), fetch(at + 9), fetch(at + 10));
    sum += vec4(fetch(at + 81), fetch(at + 82), fetch(at + 90), fetch(at + 91));
  }
  out_picture = sum;
  out_layers = vec4(0.0);
}
)glsl";

/// Look-ups per second of a shader that does nothing else. A look-up is 8 fetches of a cell's
/// corners from the atlas's texels; neighbouring pixels read neighbouring cells. No march can be
/// faster. For a software renderer the seconds are CPU time.
double fetch_rate(const BrickAtlas& atlas) {
  const gl::EglContext context({});
  const bool software = is_software(context.renderer());
  const gl::TileTarget target(fetch_side, false, false);
  const gl::Program program("fetch.frag", "#define LOOKUPS " + std::to_string(lookups) + "\n",
                            {{"fetch.frag", shader}});
  const std::size_t texels = atlas.bricks.size() * brick_texels;
  const gl::Triangle triangle;
  GLuint buffer = 0, texture = 0;
  glCreateBuffers(1, &buffer);
  glNamedBufferStorage(buffer, GLsizeiptr(texels * sizeof(float)), atlas.texels32.get(), 0);
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture);
  glTextureBuffer(texture, GL_R32F, buffer);
  program.set("texels", 0);
  program.set("cells", int(texels) - 91);

  std::vector<double> times;
  for (int i = 0; i < 8; ++i) {
    const Stopwatch watch;
    target.bind(0);
    glBindTextureUnit(0, texture);
    triangle.draw(program, fetch_side, fetch_side);
    glFinish();
    if (i == 0) continue;  // the first draw compiles
    times.push_back(software ? watch.cpu_ms() : watch.ms());
  }
  context.check("fetching texels");
  glDeleteTextures(1, &texture);
  glDeleteBuffers(1, &buffer);
  return 1e3 * lookups * double(fetch_side) * fetch_side / median(times);
}

/// White noise in a random selection of the 8^3 blocks of a cube of n^3 voxels.
Field make_blocks(int n, double fraction) {
  std::uint32_t state = 1;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return double(state >> 8) * 0x1p-24;
  };
  DenseField field("density", glm::ivec3(n), 1, glm::dmat4(1));
  for (int x = 0; x < n; x += 8) {
    std::vector<float> slab(std::size_t(8 * n * n));
    for (int y = 0; y < n; y += 8)
      for (int z = 0; z < n; z += 8) {
        if (random() >= fraction) continue;
        for (int i = 0; i < 512; ++i)
          slab[std::size_t(((i >> 6) * n + y + (i >> 3 & 7)) * n + z + (i & 7))] = float(random());
      }
    field.add(slab);
  }
  return field.finish();
}

using SharedField = std::shared_ptr<const Field>;

SharedField shared(Field field) { return std::make_shared<const Field>(std::move(field)); }

/// One point of a curve: a field that is its own luminance, marched as the scene says.
struct Point {
  std::string name;
  glm::ivec2 resolution;
  Session session;
  std::shared_ptr<Marcher> gpu = open_gpu();
  Wish wish{.confirm = false};
  double lookups = 0;
  std::vector<double> times, work;

  Point(std::string label, const SharedField& field, const Scene& scene)
      : name(std::move(label)),
        resolution(scene.resolution),
        session(make_view(scene, field, field)) {
    if (scene.tolerance) {
      wish.plan = session.plan(*gpu, wish);
      name += ", " + method_text(wish.plan->chosen.method);
    }
    Wish counted = wish;
    counted.count = true;
    lookups = double(session.draw(*gpu, counted).stats.samples);
    session.draw(*gpu, wish);  // compiles
  }

  void draw() {
    const RenderStats stats = session.draw(*gpu, wish).stats;
    times.push_back(stats.march_ms);
    work.push_back(is_software(stats.renderer) ? stats.cpu_ms : stats.gpu_ms);
  }
};

class Curve {
 public:
  Curve(std::string title, double limit) : title_(std::move(title)), limit_(limit) {}

  /// Adds two points: uniform steps and cells.
  void add(const std::string& name, const SharedField& field, int side, double extinction) {
    Scene scene = scene_of(side, extinction);
    points_.emplace_back(name + ", cells", field, scene);
    scene.step = 1;
    points_.emplace_back(name + ", uniform 1", field, scene);
  }
  void add_tolerance(double tolerance, const SharedField& field, int side, double extinction) {
    Scene scene = scene_of(side, extinction);
    scene.tolerance = tolerance;
    points_.emplace_back(formatted("%.0e", tolerance), field, scene);
  }

  /// Prints a table. "of limit" is the rate over the limit; the march spends the rest of its time
  /// on work other than fetching.
  void print() {
    for (int i = 0; i < rounds; ++i)
      for (Point& point : points_) point.draw();
    std::printf("\n%s\n%-40s %9s %9s %12s %12s %10s %10s\n", title_.c_str(), "", "ms", "work ms",
                "look-ups", "M look-ups/s", "of limit", "ns/pixel");
    for (const Point& p : points_) {
      const double work = median(p.work), rate = 1e3 * p.lookups / work;
      const glm::ivec2 size = p.resolution;
      std::printf("%-40s %9.2f %9.2f %12.0f %12.1f %9.0f%% %10.1f\n", p.name.c_str(),
                  median(p.times), work, p.lookups, 1e-6 * rate, 100 * rate / limit_,
                  1e6 * work / (double(size.x) * double(size.y)));
    }
    std::fflush(stdout);
  }

 private:
  static Scene scene_of(int side, double extinction) {
    Scene scene;
    scene.resolution = {side, side};
    scene.extinction = extinction;
    scene.luminance_grid = "density";
    return scene;
  }

  std::string title_;
  double limit_;
  std::deque<Point> points_;  // a deque, so that points stay in place
};

void print_memory(const char* name, const Field& field) {
  const AtlasSize size = build_atlas(field).size;
  std::printf("%-34s %12llu active voxels %10.2f MiB %8.2f bytes a voxel\n", name,
              static_cast<unsigned long long>(field.active_voxels),
              double(size.bytes()) / (1 << 20), double(size.bytes()) / double(field.active_voxels));
}

void run() {
  constexpr double fog_extinction = 20;  // the peers' scene A
  constexpr int side = 512;
  const SharedField fog = shared(bench::make_fog(256));
  const double limit = fetch_rate(build_atlas(*fog));
  std::printf("%s\nfetching alone: %.1f M look-ups/s of work\n", description(*open_gpu()).c_str(),
              1e-6 * limit);

  Curve pixels("time against pixels: fog 256^3", limit);
  for (const int n : {128, 256, 512, 1024})
    pixels.add(std::to_string(n) + "x" + std::to_string(n), fog, n, fog_extinction);
  pixels.print();

  Curve voxels("time against voxels: fog, 512x512", limit);
  for (const int n : {64, 128, 256})
    voxels.add(std::to_string(n) + "^3", shared(bench::make_fog(n)), side, fog_extinction);
  voxels.print();

  // A ray through the full cube, of mean 1/2, has depth 3, whatever fraction is active.
  Curve fractions("time against active fraction: noise in blocks of 128^3, 512x512", limit);
  for (const double part : {0.01, 0.03, 0.1, 0.3, 1.0})
    fractions.add(std::to_string(int(100 * part)) + " %", shared(make_blocks(128, part)), side,
                  3 / (128 * 0.5));
  fractions.print();

  Curve depths("time against optical depth: fog 256^3, 512x512", limit);
  for (const double extinction : {0.2, 2.0, 20.0, 200.0, 2000.0})
    depths.add("extinction " + std::to_string(int(extinction * 10) / 10.0).substr(0, 6), fog, side,
               extinction);
  depths.print();

  Curve tolerances("time against tolerance: fog 256^3, 512x512", limit);
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5})
    tolerances.add_tolerance(tolerance, fog, side, fog_extinction);
  tolerances.print();

  std::printf("\nmemory against active voxels\n");
  for (const int n : {64, 128, 256})
    print_memory(("fog " + std::to_string(n) + "^3").c_str(), bench::make_fog(n));
  for (const double part : {0.01, 0.03, 0.1, 0.3, 1.0})
    print_memory(("blocks, " + std::to_string(int(100 * part)) + " %").c_str(),
                 make_blocks(128, part));
}

}  // namespace

int main() { return bench::run("scaling", run); }
