// Renders a field of its own making through the installed library: no file, no GL.
#include <psivox/atlas.h>
#include <psivox/error.h>
#include <psivox/field.h>
#include <psivox/image.h>
#include <psivox/medium.h>
#include <psivox/reference.h>
#include <psivox/renderer.h>
#include <psivox/scene.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>

namespace {

/// A cube of 8^3 voxels of value 1, its own storage.
std::shared_ptr<const psivox::Field> make_cube() {
  const auto values = std::make_shared<std::array<float, 512>>();
  values->fill(1);
  auto field = std::make_shared<psivox::Field>();
  field->name = "density";
  field->value_type = "float";
  field->active_box = {glm::ivec3(0), glm::ivec3(7)};
  field->active_voxels = 512;
  field->leaves.push_back({glm::ivec3(0), values->data()});
  field->storage = values;
  return field;
}

}  // namespace

int main() try {
  psivox::Scene scene;
  scene.resolution = {33, 33};
  scene.extinction = 0.25;
  scene.projection = psivox::Projection::orthographic;
  scene.early_termination = 0;
  const psivox::View view = psivox::make_view(scene, make_cube(), nullptr);

  const psivox::MediumAtlas atlas = psivox::build_medium_atlas(view);
  const psivox::RenderResult march = psivox::render_march_double(view, atlas);
  const psivox::ReferenceResult reference = psivox::render_reference(view);
  const psivox::Comparison difference = psivox::compare_images(march.image, reference.image);

  // Along the middle ray the field is 1 over 7 voxels and falls to 0 over one more at each end:
  // optical depth 0.25 * 8.
  const double opacity = march.image.rgba()[4 * (16 * 33 + 16) + 3];
  const double expected = 1 - std::exp(-2.0);
  std::printf("middle %.9f, expected %.9f; march - reference: RMS %.2g\n", opacity, expected,
              difference.rms);
  // Pictures are floats, which round 0.86 by 3e-8.
  return std::abs(opacity - expected) < 1e-7 && difference.rms < 1e-7 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "consumer: %s\n", error.what());
  return 1;
}
