#include "gl/grid_textures.h"

#include <epoxy/gl.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "gl/march_program.h"
#include "march/marcher.h"

namespace psivox::gl {

/// A brick atlas on the GPU: page table and constants as texture buffers; texels as one or more
/// texture buffers for exact filtering, or as one 3D texture of bricks for the hardware's.
/// Needs a current context for its whole life.
class AtlasTextures {
 public:
  /// `beside`: an atlas of the same bricks, whose texels become further channels of this one's; for
  /// exact filtering only. Throws Error(graphics) where the device's limits are too small,
  /// Error(memory) where its memory is.
  AtlasTextures(const BrickAtlas& atlas, Filter filter, const BrickAtlas* beside);
  ~AtlasTextures();
  AtlasTextures(const AtlasTextures&) = delete;
  AtlasTextures& operator=(const AtlasTextures&) = delete;

  /// Number of texel buffers, at least 1 (shader constant DENSITY_BUFFERS or LUMINANCE_BUFFERS).
  int buffers() const { return int(texels_.size()); }
  /// Texels in each buffer but the last: whole bricks.
  int texels_per_buffer() const { return texels_per_buffer_; }

  void bind(int first_unit) const;
  /// Units that bind uses: pages, constants, bricks, then buffers() texel buffers.
  int units() const { return 3 + buffers(); }

 private:
  GLuint buffer_texture(GLenum format, const void* data, std::size_t bytes, GLbitfield flags = 0);
  GLuint texture_of_last_buffer(GLenum format) const;
  /// A texture of an atlas's array, from the value `first` on. A driver that draws on the CPU uses
  /// the array itself.
  template <typename T>
  GLuint texel_texture(GLenum format, const std::shared_ptr<T[]>& array, std::size_t first,
                       std::size_t count);
  void upload_pages(const std::vector<std::uint32_t>& entries);
  /// Buffers of so many texels together: `upload(first, count)` makes the texture of one.
  template <typename Upload>
  void upload_texels(std::uint64_t texels, const Upload& upload);
  void upload_buffers(const BrickAtlas& atlas, const BrickAtlas* beside);
  /// `pairs`: a texel is two words.
  void upload_codes(const BrickAtlas& atlas, bool pairs);
  /// A texture of `count` texels, `from` one on, each followed by those of another atlas.
  GLuint upload_pairs(const BrickAtlas& atlas, const BrickAtlas& beside, std::uint64_t from,
                      std::uint64_t count);
  void upload_bricks(const BrickAtlas& atlas);

  GLuint pages_ = 0, constants_ = 0, bricks_ = 0;
  std::vector<GLuint> texels_;
  std::vector<GLuint> storage_;                      ///< buffer objects
  std::vector<std::shared_ptr<const void>> arrays_;  ///< that the driver uses
  std::uint64_t max_texels_ = 0;
  bool in_place_;
  int texels_per_buffer_ = brick_texels;
};

namespace {

/// A vector's texels, padded to four values: three take llvmpipe 1.2 times as long to fetch.
std::vector<float> padded(const float* texels, std::size_t count) {
  std::vector<float> result(count * 4);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 3; ++c) result[4 * i + c] = texels[3 * i + c];
  return result;
}

/// Texels of three floats that are padded: no limit on memory counts what is added to them, 16 MiB.
constexpr std::uint64_t most_padded = std::uint64_t{1} << 22;

GLenum format_of(const BrickAtlas& atlas) { return atlas.channels == 1 ? GL_R32F : GL_RGB32F; }

}  // namespace

bool draws_from_host() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return !test_limits.copies_texels && renderer && is_software(renderer) &&
         epoxy_has_gl_extension("GL_AMD_pinned_memory");
}

AtlasTextures::AtlasTextures(const BrickAtlas& atlas, Filter filter, const BrickAtlas* beside)
    : in_place_(draws_from_host()) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
  max_texels_ = std::uint64_t(limit);
  if (test_limits.buffer_texels) max_texels_ = std::min(max_texels_, test_limits.buffer_texels);

  const std::size_t entries = atlas.pages.entries.size();
  if (entries > max_texels_)
    throw DeviceFull(ExitCode::graphics,
                     "the page table has " + std::to_string(entries) +
                         " entries, more than the device's texture buffers hold");
  constants_ = buffer_texture(format_of(atlas), atlas.constants.data(),
                              atlas.constants.size() * sizeof(float));
  if (filter == Filter::hardware) {
    upload_bricks(atlas);
  } else {
    upload_pages(atlas.pages.entries);
    if (atlas.codes)
      upload_codes(atlas, beside);
    else
      upload_buffers(atlas, beside);
  }
}

AtlasTextures::~AtlasTextures() {
  if (!arrays_.empty()) glFinish();  // draws may still read them
  for (const GLuint texture : {pages_, constants_, bricks_}) glDeleteTextures(1, &texture);
  glDeleteTextures(GLsizei(texels_.size()), texels_.data());
  glDeleteBuffers(GLsizei(storage_.size()), storage_.data());
}

GLuint AtlasTextures::buffer_texture(GLenum format, const void* data, std::size_t bytes,
                                     GLbitfield flags) {
  GLuint buffer = 0;
  glCreateBuffers(1, &buffer);
  storage_.push_back(buffer);
  // An empty store is not allowed; 16 bytes are a texel of any format.
  std::array<std::byte, 16> padded{};
  if (data && bytes > 0 && bytes < padded.size()) std::memcpy(padded.data(), data, bytes);
  if (bytes < padded.size()) data = padded.data();
  glNamedBufferStorage(buffer, GLsizeiptr(std::max(bytes, padded.size())), data, flags);
  return texture_of_last_buffer(format);
}

GLuint AtlasTextures::texture_of_last_buffer(GLenum format) const {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture);
  glTextureBuffer(texture, format, storage_.back());
  return texture;
}

template <typename T>
GLuint AtlasTextures::texel_texture(GLenum format, const std::shared_ptr<T[]>& array,
                                    std::size_t first, std::size_t count) {
  constexpr std::size_t page = 4096;  // of the extension
  T* const texels = array.get() + first;
  if (in_place_ && count > 0 && reinterpret_cast<std::uintptr_t>(texels) % page == 0) {
    constexpr GLenum host_memory = GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD;
    storage_.push_back(0);
    glGenBuffers(1, &storage_.back());
    glBindBuffer(host_memory, storage_.back());
    glBufferData(host_memory, GLsizeiptr(count * sizeof(T)), texels, GL_STATIC_DRAW);
    glBindBuffer(host_memory, 0);
    arrays_.push_back(array);
    return texture_of_last_buffer(format);
  }
  return buffer_texture(format, texels, count * sizeof(T));
}

void AtlasTextures::upload_pages(const std::vector<std::uint32_t>& entries) {
  pages_ = buffer_texture(GL_R32UI, entries.data(), entries.size() * sizeof(std::uint32_t));
}

template <typename Upload>
void AtlasTextures::upload_texels(std::uint64_t texels, const Upload& upload) {
  if (texels > std::uint64_t(std::numeric_limits<int>::max()))
    throw DeviceFull(ExitCode::graphics, "an atlas of " + std::to_string(texels) +
                                             " texels is beyond what a shader can address (2^31)");
  const std::uint64_t per_buffer =
      std::max<std::uint64_t>(max_texels_ / brick_texels, 1) * brick_texels;
  texels_per_buffer_ = int(std::min(per_buffer, texels + brick_texels));
  std::uint64_t first = 0;
  do {
    texels_.push_back(upload(first, std::min(texels - first, per_buffer)));
    first += per_buffer;
  } while (first < texels);
}

void AtlasTextures::upload_buffers(const BrickAtlas& atlas, const BrickAtlas* beside) {
  const auto channels = std::uint64_t(atlas.channels);
  const std::uint64_t texels = atlas.bricks.size() * brick_texels;
  upload_texels(texels, [&](std::uint64_t first, std::uint64_t count) {
    if (beside) return upload_pairs(atlas, *beside, first, count);
    const std::uint64_t at = first * channels;
    if (channels == 1 || in_place_ || texels > most_padded)
      return texel_texture(format_of(atlas), atlas.texels, at, count * channels);
    const std::vector<float> four = padded(atlas.texels.get() + at, count);
    return buffer_texture(GL_RGBA32F, four.data(), four.size() * sizeof(float));
  });
}

void AtlasTextures::upload_codes(const BrickAtlas& atlas, bool pairs) {
  const std::uint64_t words = pairs ? 2 : 1;
  upload_texels(atlas.code_count() / words, [&](std::uint64_t first, std::uint64_t count) {
    return texel_texture(pairs ? GL_RGBA32UI : GL_RG32UI, atlas.codes, first * words,
                         count * words);
  });
}

GLuint AtlasTextures::upload_pairs(const BrickAtlas& atlas, const BrickAtlas& beside,
                                   std::uint64_t from, std::uint64_t count) {
  const bool vector = beside.channels == 3;
  const std::size_t others = vector ? 3 : 1;
  float* const own = atlas.texels.get() + from;
  float* const other = beside.texels.get() + from * others;
  const std::size_t width = 1 + others;
  // a piece at a time, so that what is written last is still in the processor's cache
  constexpr std::size_t piece = std::size_t{1} << 18;
  std::vector<float> pairs(std::min(count, piece) * width);
  const GLuint texture = buffer_texture(vector ? GL_RGBA32F : GL_RG32F, nullptr,
                                        count * width * sizeof(float), GL_DYNAMIC_STORAGE_BIT);
  for (std::size_t first = 0; first < count; first += piece) {
    const std::size_t size = std::min(count - first, piece);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, size, 65536), [&](const auto& some) {
      for (std::size_t i = some.begin(); i != some.end(); ++i) {
        float* to = pairs.data() + i * width;
        to[0] = own[first + i];
        for (std::size_t c = 0; c < others; ++c) to[1 + c] = other[(first + i) * others + c];
      }
    });
    glNamedBufferSubData(storage_.back(), GLintptr(first * width * sizeof(float)),
                         GLsizeiptr(size * width * sizeof(float)), pairs.data());
  }
  return texture;
}

void AtlasTextures::upload_bricks(const BrickAtlas& atlas) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &limit);
  // A page's payload holds the brick's place, 10 bits an axis.
  const std::uint64_t widest = std::min<std::uint64_t>(std::uint64_t(limit) / brick_values, 1024);
  const std::uint64_t bricks = std::max<std::uint64_t>(atlas.bricks.size(), 1);
  const std::uint64_t nx = std::min(bricks, widest);
  const std::uint64_t ny = std::min((bricks + nx - 1) / nx, widest);
  const std::uint64_t nz = (bricks + nx * ny - 1) / (nx * ny);
  if (nz > widest)
    throw DeviceFull(
        ExitCode::graphics,
        "an atlas of " + std::to_string(bricks) +
            " bricks does not fit the device's largest 3D texture; use --filter exact");
  glCreateTextures(GL_TEXTURE_3D, 1, &bricks_);
  glTextureStorage3D(bricks_, 1, format_of(atlas), GLsizei(nx * brick_values),
                     GLsizei(ny * brick_values), GLsizei(nz * brick_values));
  glTextureParameteri(bricks_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(bricks_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const std::size_t per_brick = brick_texels * std::size_t(atlas.channels);
  const auto place = [&](std::uint64_t slot) {
    return glm::ivec3(int(slot % nx), int(slot / nx % ny), int(slot / (nx * ny)));
  };
  std::vector<std::uint32_t> entries = atlas.pages.entries;
  for (std::uint32_t& entry : entries) {
    if (entry_kind(entry) != EntryKind::brick) continue;
    const glm::uvec3 at(place(atlas.pages.slot(entry)));
    entry = make_entry(EntryKind::brick, at.x | at.y << 10 | at.z << 20);
  }
  upload_pages(entries);
  for (std::size_t slot = 0; slot < atlas.bricks.size(); ++slot) {
    const glm::ivec3 at = place(slot) * brick_values;
    glTextureSubImage3D(bricks_, 0, at.x, at.y, at.z, brick_values, brick_values, brick_values,
                        atlas.channels == 1 ? GL_RED : GL_RGB, GL_FLOAT,
                        atlas.texels.get() + slot * per_brick);
  }
  texels_.push_back(buffer_texture(GL_R32F, nullptr, 0));  // what the shader declares, unread
}

void AtlasTextures::bind(int first_unit) const {
  GLuint unit = GLuint(first_unit);
  glBindTextureUnit(unit++, pages_);
  glBindTextureUnit(unit++, constants_);
  glBindTextureUnit(unit++, bricks_);
  for (const GLuint texture : texels_) glBindTextureUnit(unit++, texture);
}

GridTextures::GridTextures(const MediumAtlas& atlas, Filter filter)
    : atlas_(atlas), filter_(filter) {
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  // float32 texels that the device reads from the host's memory are not copied into pairs
  const bool in_place = draws_from_host() && atlas.density.texels;
  const bool pairs = atlas.paired && filter == Filter::exact && (atlas.density.codes || !in_place);
  int needed = MarchProgram::first_grid_unit;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (!grids[i] || (pairs && i == luminance_grid)) continue;
    const BrickAtlas* beside = pairs && i == density_grid ? grids[luminance_grid] : nullptr;
    textures_[i] = std::make_unique<const AtlasTextures>(*grids[i], filter, beside);
    needed += textures_[i]->units();
  }
  GLint units = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  if (needed > units)
    throw DeviceFull(ExitCode::graphics, "the atlas takes " + std::to_string(needed) +
                                             " textures, and the device has " +
                                             std::to_string(units) + "");
}

ProgramKey GridTextures::key(MarchSetup& setup) const {
  PerGrid<int> buffers{};
  int texels_per_buffer = brick_texels;
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    if (!textures_[i]) continue;
    buffers[i] = textures_[i]->buffers();
    // grids of several buffers have the same: the device's limit
    texels_per_buffer = std::max(texels_per_buffer, textures_[i]->texels_per_buffer());
  }
  return program_key(setup, buffers, texels_per_buffer);
}

void GridTextures::bind(const MarchProgram& march) const {
  for (std::size_t i = 0; i < textures_.size(); ++i)
    if (textures_[i]) textures_[i]->bind(march.grid_unit(int(i)));
}

GridTextures::~GridTextures() = default;

}  // namespace psivox::gl
