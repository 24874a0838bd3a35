// Draws two cameras of one medium through the installed library: no file, no GL.
#include <psivox/draw.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>

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

float middle_opacity(const psivox::Image& image) {
  const int middle = image.height / 2 * image.width + image.width / 2;
  return image.rgba()[std::size_t(4 * middle + 3)];
}

}  // namespace

int main() try {
  psivox::Scene scene;
  scene.resolution = {33, 33};
  scene.extinction = 0.25;
  scene.projection = psivox::Projection::orthographic;
  scene.early_termination = 0;

  psivox::Session session(psivox::make_view(scene, make_cube(), nullptr));
  const auto marcher = psivox::open_double();
  const auto reference = psivox::open_reference();
  bool right = true;
  for (const glm::dvec3& position : {glm::dvec3(3.5, 3.5, 30), glm::dvec3(30, 3.5, 3.5)}) {
    scene.camera_position = position;
    scene.camera_target = glm::dvec3(3.5);
    const psivox::Wish wish{.scene = scene};
    const psivox::Image image = session.draw(*marcher, wish).image;
    const double rms = psivox::compare_images(image, session.draw(*reference, wish).image).rms;
    // Along the middle ray the field is 1 over 7 voxels and falls to 0 over one more at each end:
    // optical depth 0.25 * 8. Pictures are floats, which round 0.86 by 3e-8; the picture was asked
    // for with the default tolerance of 1e-3.
    const double error = std::abs(middle_opacity(image) - (1 - std::exp(-2.0)));
    std::printf("middle ray off by %.1e, picture by RMS %.1e\n", error, rms);
    right = right && error < 1e-3 && rms < 1e-3;
  }
  return right ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "consumer: %s\n", error.what());
  return 1;
}
