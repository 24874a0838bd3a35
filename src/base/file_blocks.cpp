#include "base/file_blocks.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"

namespace psivox {
namespace {

constexpr std::int64_t block = 128 << 10;  // [bytes]
constexpr std::size_t most_kept = 128;     // blocks: 16 MiB

/// Size of a regular file; throws Error(input) if it is none.
std::int64_t size_of(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) {
    throw Error(ExitCode::input, path == "-" ? "-: a volume cannot be read from the standard input"
                                             : path.string() + ": no such file");
  }
  if (std::filesystem::is_directory(status)) {
    const std::string format = foreign_format(path.string());
    throw Error(ExitCode::input,
                path.string() + ": " + (format.empty() ? "is a directory, not a file" : format));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw Error(ExitCode::input, path.string() + ": is no regular file");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (code) throw Error(ExitCode::input, path.string() + ": " + code.message());
  return static_cast<std::int64_t>(size);
}

}  // namespace

FileBlocks::FileBlocks(const std::filesystem::path& path)
    : path_(path.string()), size_(size_of(path)) {
  std::string why;
  file_ = open_input(path, why);
  if (file_ < 0) throw Error(ExitCode::input, path_ + ": cannot be opened for reading");
}

FileBlocks::FileBlocks(std::string path, int descriptor)
    : path_(std::move(path)), file_(descriptor) {
  struct stat status {};
  if (fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(file_);
    throw Error(ExitCode::input, path_ + ": is no regular file");
  }
  size_ = status.st_size;
}

FileBlocks::~FileBlocks() {
  if (file_ >= 0) close(file_);
}

FileRun FileBlocks::run(std::int64_t position) {
  const std::int64_t begin = position / block * block;
  {
    const std::lock_guard lock(mutex_);
    const auto kept = runs_.find(begin);
    if (kept != runs_.end() && kept->second.has(position)) return kept->second;
  }
  FileRun run = read(begin, block);
  if (!run.has(position)) return {position, 0, nullptr};
  const std::lock_guard lock(mutex_);
  if (runs_.emplace(begin, run).second) oldest_first_.push_back(begin);
  if (oldest_first_.size() > most_kept) {
    runs_.erase(oldest_first_.front());
    oldest_first_.pop_front();
  }
  return run;
}

FileRun FileBlocks::read(std::int64_t begin, std::int64_t size) const {
  size = std::min(size, size_ - begin);
  if (size <= 0) return {begin, 0, nullptr};
  const auto bytes = std::make_shared_for_overwrite<char[]>(static_cast<std::size_t>(size));
  std::int64_t done = 0;
  while (done < size) {
    const ssize_t got =
        pread(file_, bytes.get() + done, static_cast<std::size_t>(size - done), begin + done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw std::runtime_error(std::generic_category().message(errno));
    if (got == 0) break;  // the file is shorter than it was
    done += got;
  }
  return {begin, done, bytes};
}

FileBuffer::FileBuffer(FileBlocks& file, Progress progress)
    : file_(file), progress_(std::move(progress)) {}

void FileBuffer::expect(std::int64_t bytes) {
  expected_from_ = reported_ = position();
  expected_ = std::max<std::int64_t>(bytes, 1);
}

void FileBuffer::report(std::int64_t reached) {
  if (!progress_ || expected_ == 0 || reached <= reported_) return;
  reported_ = reached;
  const double fraction =
      static_cast<double>(reached - expected_from_) / static_cast<double>(expected_);
  progress_(std::clamp(fraction, 0.0, 1.0));
}

FileBuffer::int_type FileBuffer::underflow() {
  const std::int64_t here = position();
  if (!run_.has(here)) {
    FileRun next = only_ > 0 ? file_.read(here, only_) : file_.run(here);
    if (next.size == 0) return traits_type::eof();
    run_ = std::move(next);
    report(here);
  }
  begin_ = run_.begin;
  char* const bytes = const_cast<char*>(run_.bytes.get());  // a streambuf's type; never written to
  setg(bytes, bytes + (here - begin_), bytes + run_.size);
  return traits_type::to_int_type(*gptr());
}

FileBuffer::pos_type FileBuffer::seekoff(off_type offset, std::ios_base::seekdir from,
                                         std::ios_base::openmode) {
  std::int64_t origin = 0;
  if (from == std::ios_base::cur) origin = position();
  if (from == std::ios_base::end) origin = file_.size();
  // A damaged file can hold any offset; the sum must not overflow.
  if (offset < -origin || offset > file_.size() - origin) return pos_type(off_type(-1));
  const std::int64_t target = origin + offset;
  if (target >= begin_ && target - begin_ <= egptr() - eback()) {
    setg(eback(), eback() + (target - begin_), egptr());
  } else {
    setg(nullptr, nullptr, nullptr);
    begin_ = target;
  }
  return pos_type(target);
}

FileBuffer::pos_type FileBuffer::seekpos(pos_type position, std::ios_base::openmode mode) {
  return seekoff(off_type(position), std::ios_base::beg, mode);
}

namespace {

using namespace std::string_view_literals;

/// A format, what its files begin with or are called, and how to read it. `array`: what
/// psivox.field takes in Python, by x, y, z, with voxel sizes and the origin where the file has
/// them; $ is the file's name.
struct Format {
  std::string_view name;
  std::string_view magic;
  std::size_t offset;  ///< of the magic
  std::string_view extensions;
  std::string_view array;
};

constexpr Format formats[] = {
    {"half of an Analyze image", "", 0, ".hdr", "nibabel.load($).get_fdata()"},
    {"a DICOM image", "DICM", 128, ".dcm .dicom",
     "numpy.atleast_3d(pydicom.dcmread($).pixel_array.T)"},
    {"a VTK file", "# vtk DataFile", 0, ".vtk",
     "(g := pyvista.read($)).active_scalars.reshape(g.dimensions, order='F'), g.spacing, g.origin"},
    {"a VTK file", "<VTKFile", 0, ".vti",
     "(g := pyvista.read($)).active_scalars.reshape(g.dimensions, order='F'), g.spacing, g.origin"},
    {"an HDF5 file", "\x89HDF\r\n\x1a\n"sv, 0, ".h5 .hdf5", "h5py.File($)['NAME'][:].T"},
    {"a TIFF file", "II*\0"sv, 0, ".tif .tiff", "tifffile.imread($).T"},
    {"a TIFF file", "II+\0"sv, 0, "", "tifffile.imread($).T"},
    {"a TIFF file", "MM\0*"sv, 0, "", "tifffile.imread($).T"},
    {"a numpy array", "\x93NUMPY", 0, ".npy", "numpy.load($)"},
    {"a MetaImage", "ObjectType = Image", 0, ".mhd .mha",
     "SimpleITK.GetArrayFromImage(i := SimpleITK.ReadImage($)).T, i.GetSpacing(), i.GetOrigin()"},
    {"a Zarr array", "", 0, ".zarr", "zarr.open($)[:].T"},
    {"a file of raw values", "", 0, ".raw .vol",
     "numpy.fromfile($, 'u1').reshape(DEPTH, HEIGHT, WIDTH).T"},
};

bool has_extension(std::string_view path, std::string_view extensions) {
  std::string name = lower_case(path);
  while (name.ends_with('/')) name.pop_back();
  return std::ranges::any_of(split(extensions, ' '),
                             [&](const auto& extension) { return name.ends_with(extension); });
}

/// In the array of a format, as a word of Python.
std::string with_name(std::string_view array, const std::string& path) {
  std::string text(array), word;
  for (const char c : path) word += (c == '\'' || c == '\\' ? "\\" : "") + std::string(1, c);
  return text.replace(text.find('$'), 1, in_quotes(word));
}

std::string advice(const Format& format, const std::string& path) {
  return "is " + std::string(format.name) + ", not a .vdb; in Python psivox.render(psivox.field(" +
         with_name(format.array, path) + ")).write('x.png') draws it, see docs/interchange.md";
}

}  // namespace

std::string file_stamp(const std::filesystem::path& path) {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(path, missing);
  if (missing) return "";
  const auto size = std::filesystem::file_size(path, missing);
  return std::to_string(time.time_since_epoch().count()) + "/" + std::to_string(size);
}

std::string foreign_format(const std::string& path, std::string_view head) {
  const auto begins = [&](std::string_view magic, std::size_t offset = 0) {
    return head.size() > offset && head.substr(offset).starts_with(magic);
  };
  for (const Format& format : formats)
    if (!format.magic.empty() && begins(format.magic, format.offset)) return advice(format, path);
  // XML's first line may stand before
  if (begins("<?xml") && head.substr(0, 1024).find("<VTKFile") != std::string_view::npos)
    return foreign_format(path, "<VTKFile");
  for (const Format& format : formats)
    if (has_extension(path, format.extensions)) return advice(format, path);
  if (has_extension(path, ".img"))
    return "holds the values of " +
           in_quotes(std::filesystem::path(path).replace_extension(".hdr").string()) +
           "; give that file";
  if (begins("\x1f\x8b") && has_extension(path, ".nii.gz")) return "is a damaged gzip";
  if (begins("\x1f\x8b")) return "is compressed; gunzip -k " + shell_word(path) + " unpacks it";
  for (const auto& [name, extensions] :
       {std::pair("NIfTI", ".nii .nii.gz"), {"NRRD", ".nrrd .nhdr"}, {"NanoVDB", ".nvdb"}})
    if (!head.empty() && has_extension(path, extensions))
      return std::string("does not begin as a file of ") + name + " does; is it damaged?";
  if (begins("PK\3\4")) return "is an archive; unzip " + shell_word(path) + " unpacks it";
  return {};
}

}  // namespace psivox
