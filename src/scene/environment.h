#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace psivox {

/// Light from far away, by the direction towards it, as a latitude-longitude map has it: the top
/// row is the zenith. With z up the map is Blender's, whose middle is towards +X; with y up it is
/// OpenEXR's (ImfEnvmap.h), whose middle is towards +Z. What is left of the middle is a turn to the
/// left, counterclockwise seen from above.
class Environment {
 public:
  /// `radiance`: from the top left pixel, row by row, at least 0. `rotation` [radians] turns the
  /// map counterclockwise.
  Environment(const glm::ivec2& size, std::vector<glm::vec3> radiance, bool z_up, double rotation);

  /// The radiance if it is the same everywhere.
  const std::optional<glm::dvec3>& constant() const { return constant_; }

  /// The radiance in a direction, between the pixels' centres.
  glm::dvec3 at(const glm::dvec3& towards) const;

  /// A part of the map, as one direction.
  struct Source {
    glm::dvec3 towards{0};   ///< normalised: the middle of its light
    glm::dvec3 radiance{0};  ///< its share of the mean over all directions
  };
  /// At most `count` parts that are all of the map's light: a rectangle of the sphere, whose sides
  /// are along no axis, is halved where its light scatters most about its middle (Viriyothai and
  /// Debevec 2009, Variance minimization light probe sampling). A small bright spot, such as a sun,
  /// is a part of its own.
  std::vector<Source> sources(int count) const;

 private:
  /// Light of some cells.
  struct Light {
    glm::dvec3 radiance{0};  ///< times the solid angle, over the sphere's
    glm::dvec3 moment{0};    ///< the amount times the direction

    /// What counts: a tolerance takes all channels alike.
    double amount() const { return (radiance.x + radiance.y + radiance.z) / 3; }
    /// Sum of the amounts times the squares of their distances from their middle.
    double scatter() const;
    Light operator+(const Light& o) const { return {radiance + o.radiance, moment + o.moment}; }
    Light operator-(const Light& o) const { return {radiance - o.radiance, moment - o.moment}; }
  };
  struct Cells {
    glm::ivec2 begin{0}, end{0};
  };

  glm::dvec3 direction(double u, double v) const;  ///< of a place in the map, 0 to 1
  void sum_up();
  Light within(const Cells& cells) const;
  /// The two that scatter least together.
  std::pair<Cells, Cells> halves(const Cells& all) const;

  glm::ivec2 size_;
  std::vector<glm::vec3> radiance_;
  bool z_up_;
  double rotation_;
  std::optional<glm::dvec3> constant_;
  glm::ivec2 cells_{0};      ///< across the sphere, which is tilted
  std::vector<Light> sums_;  ///< of the cells left of and above each corner
};

}  // namespace psivox
