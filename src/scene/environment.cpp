#include "scene/environment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <queue>

namespace psivox {
namespace {

constexpr double pi = glm::pi<double>();

/// Cells across the map by which it is divided: at least so many, whose pixels are divided, and at
/// most, each of several pixels.
constexpr int least_cells = 512, most_cells = 1024;

/// Turns directions away from the axes. Volumes have faces along axes, and rectangles with a side
/// along such a face's horizon err with one sign. Of 60 random turns this one left the faces the
/// least error (docs/method.md).
glm::dmat3 tilt() {
  const glm::dvec3 x = glm::normalize(glm::dvec3(0.363, -0.298, -0.234));
  const glm::dvec3 y = glm::normalize(glm::cross(glm::dvec3(0.232, 0.513, 0.595), x));
  return {x, y, glm::cross(x, y)};
}

/// Where a direction is in a map, 0 to 1.
glm::dvec2 place_in(const glm::dvec3& d) {
  return {0.5 - std::atan2(d.y, d.x) / (2 * pi), std::atan2(std::hypot(d.x, d.y), d.z) / pi};
}

}  // namespace

double Environment::Light::scatter() const {
  const double all = amount();
  return all > 0 ? std::max(all - glm::dot(moment, moment) / all, 0.0) : 0;
}

Environment::Environment(const glm::ivec2& size, std::vector<glm::vec3> radiance, bool z_up,
                         double rotation)
    : size_(size), radiance_(std::move(radiance)), z_up_(z_up), rotation_(rotation) {
  const glm::vec3& first = radiance_.front();
  if (std::ranges::all_of(radiance_, [&](const glm::vec3& L) { return L == first; }))
    constant_ = first;
  else
    sum_up();
}

/// With psivox's axes, of a map with Blender's.
glm::dvec3 Environment::direction(double u, double v) const {
  const double longitude = pi * (1 - 2 * u) + rotation_, across = std::sin(pi * v);
  const glm::dvec3 d(across * std::cos(longitude), across * std::sin(longitude), std::cos(pi * v));
  return z_up_ ? d : glm::dvec3(d.y, d.z, d.x);
}

glm::dvec3 Environment::at(const glm::dvec3& towards) const {
  const glm::dvec3 d = z_up_ ? towards : glm::dvec3(towards.z, towards.x, towards.y);
  const glm::dvec2 place = place_in(d);
  const double turned = place.x + rotation_ / (2 * pi);
  const double x = (turned - std::floor(turned)) * size_.x - 0.5, y = place.y * size_.y - 0.5;
  const glm::dvec2 part(x - std::floor(x), y - std::floor(y));
  const auto pixel = [&](int i, int j) {
    const int column = (i + size_.x) % size_.x, row = std::clamp(j, 0, size_.y - 1);
    return glm::dvec3(radiance_[std::size_t(row) * std::size_t(size_.x) + std::size_t(column)]);
  };
  const int i = int(std::floor(x)), j = int(std::floor(y));
  return glm::mix(glm::mix(pixel(i, j), pixel(i + 1, j), part.x),
                  glm::mix(pixel(i, j + 1), pixel(i + 1, j + 1), part.x), part.y);
}

void Environment::sum_up() {
  const int parts = (least_cells + size_.x - 1) / size_.x;  // of a pixel
  const int pixels = (size_.x + most_cells - 1) / most_cells;
  const glm::ivec2 fine = parts * size_;
  cells_ = (fine + pixels - 1) / pixels;
  std::vector<Light> cells(std::size_t(cells_.x) * std::size_t(cells_.y));
  std::vector<glm::dvec3> equator(std::size_t(fine.x));
  for (int x = 0; x < fine.x; ++x) equator[std::size_t(x)] = direction((x + 0.5) / fine.x, 0.5);
  const glm::dvec3 zenith = direction(0, 0);
  for (int y = 0; y < fine.y; ++y) {
    const double v = (y + 0.5) / fine.y;
    const double area =
        (std::cos(pi * y / fine.y) - std::cos(pi * (y + 1) / fine.y)) / (2.0 * fine.x);
    const glm::vec3* const row = &radiance_[std::size_t(y / parts) * std::size_t(size_.x)];
    for (int x = 0; x < fine.x; ++x) {
      const glm::dvec3 L = area * glm::dvec3(row[x / parts]);
      const glm::dvec3 d = std::sin(pi * v) * equator[std::size_t(x)] + std::cos(pi * v) * zenith;
      Light& cell =
          cells[std::size_t(y / pixels) * std::size_t(cells_.x) + std::size_t(x / pixels)];
      cell = cell + Light{L, (L.x + L.y + L.z) / 3 * d};
    }
  }
  sums_.assign(std::size_t(cells_.x + 1) * std::size_t(cells_.y + 1), {});
  const auto sum = [&](int x, int y) -> Light& {
    return sums_[std::size_t(y) * std::size_t(cells_.x + 1) + std::size_t(x)];
  };
  const glm::dmat3 turn = tilt();
  for (const Light& cell : cells) {
    if (!(cell.amount() > 0)) continue;
    const glm::dvec2 at = place_in(turn * cell.moment) * glm::dvec2(cells_);
    Light& to = sum(std::min(int(at.x), cells_.x - 1) + 1, std::min(int(at.y), cells_.y - 1) + 1);
    to = to + cell;
  }
  for (int y = 1; y <= cells_.y; ++y)
    for (int x = 1; x <= cells_.x; ++x)
      sum(x, y) = sum(x, y) + sum(x - 1, y) + sum(x, y - 1) - sum(x - 1, y - 1);
}

Environment::Light Environment::within(const Cells& c) const {
  const auto sum = [&](int x, int y) {
    return sums_[std::size_t(y) * std::size_t(cells_.x + 1) + std::size_t(x)];
  };
  return sum(c.end.x, c.end.y) - sum(c.begin.x, c.end.y) - sum(c.end.x, c.begin.y) +
         sum(c.begin.x, c.begin.y);
}

std::pair<Environment::Cells, Environment::Cells> Environment::halves(const Cells& all) const {
  std::pair<Cells, Cells> best;
  double least = HUGE_VAL;
  for (int axis = 0; axis < 2; ++axis)
    for (int cut = all.begin[axis] + 1; cut < all.end[axis]; ++cut) {
      std::pair<Cells, Cells> two{all, all};
      two.first.end[axis] = two.second.begin[axis] = cut;
      const double scatter = within(two.first).scatter() + within(two.second).scatter();
      if (scatter < least) {
        least = scatter;
        best = two;
      }
    }
  return best;
}

std::vector<Environment::Source> Environment::sources(int count) const {
  using Part = std::pair<double, Cells>;
  const auto less = [](const Part& a, const Part& b) { return a.first < b.first; };
  std::priority_queue<Part, std::vector<Part>, decltype(less)> parts(less);
  const auto add = [&](const Cells& cells) {
    const bool one = cells.end - cells.begin == glm::ivec2(1);
    parts.push({one ? 0 : within(cells).scatter(), cells});
  };
  add({{0, 0}, cells_});
  while (int(parts.size()) < count && parts.top().first > 0) {
    const auto [a, b] = halves(parts.top().second);
    parts.pop();
    add(a);
    add(b);
  }
  std::vector<Source> sources;
  // what is less may be the rounding of sums
  const double least = 1e-12 * within({{0, 0}, cells_}).amount();
  for (; !parts.empty(); parts.pop()) {
    const Light light = within(parts.top().second);
    if (light.amount() > least) sources.push_back({glm::normalize(light.moment), light.radiance});
  }
  return sources;
}

}  // namespace psivox
