#include <algorithm>
#include <filesystem>

#include "base/file_blocks.h"
#include "base/text.h"

namespace psivox {
namespace {

using namespace std::string_view_literals;

/// A format, what its files begin with or are called, and how to read it. In `array`, an expression
/// of Python by x, y, z, $ is the file's name; docs/interchange.md has voxel sizes too.
struct Format {
  std::string_view name;
  std::string_view magic;
  std::size_t offset;  ///< of the magic
  std::string_view extensions;
  std::string_view array;
};

constexpr Format formats[] = {
    {"half of an Analyze image", "", 0, ".hdr", "nibabel.load($).get_fdata()"},
    {"a DICOM image", "DICM", 128, ".dcm .dicom", "pydicom.dcmread($).pixel_array.T"},
    {"a VTK file", "# vtk DataFile", 0, ".vtk",
     "(g := pyvista.read($)).active_scalars.reshape(g.dimensions, order='F')"},
    {"a VTK file", "<VTKFile", 0, ".vti",
     "(g := pyvista.read($)).active_scalars.reshape(g.dimensions, order='F')"},
    {"an HDF5 file", "\x89HDF\r\n\x1a\n"sv, 0, ".h5 .hdf5", "h5py.File($)['NAME'][:].T"},
    {"a TIFF file", "II*\0"sv, 0, ".tif .tiff", "tifffile.imread($).T"},
    {"a TIFF file", "II+\0"sv, 0, "", "tifffile.imread($).T"},
    {"a TIFF file", "MM\0*"sv, 0, "", "tifffile.imread($).T"},
    {"a numpy array", "\x93NUMPY", 0, ".npy", "numpy.load($)"},
    {"a MetaImage", "ObjectType = Image", 0, ".mhd .mha",
     "SimpleITK.GetArrayFromImage(SimpleITK.ReadImage($)).T"},
    {"a Zarr array", "", 0, ".zarr", "zarr.open($)[:].T"},
    {"a file of raw values", "", 0, ".raw",
     "numpy.fromfile($, 'u1').reshape(DEPTH, HEIGHT, WIDTH).T"},
};

bool has_extension(std::string_view path, std::string_view extensions) {
  std::string name = lower_case(path);
  while (name.ends_with('/')) name.pop_back();
  return std::ranges::any_of(split(extensions, ' '),
                             [&](const auto& extension) { return name.ends_with(extension); });
}

/// In the array of a format.
std::string with_name(std::string_view array, const std::string& path) {
  std::string text(array);
  return text.replace(text.find('$'), 1, in_quotes(path));
}

std::string advice(const Format& format, const std::string& path) {
  return "is " + std::string(format.name) + ", not a .vdb; in Python psivox.render(psivox.field(" +
         with_name(format.array, path) + ")).write('x.png') draws it, see docs/interchange.md";
}

}  // namespace

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
  if (begins("\x1f\x8b")) return "is compressed; gunzip -k " + in_quotes(path) + " unpacks it";
  if (begins("PK\3\4")) return "is an archive; unzip " + in_quotes(path) + " unpacks it";
  return {};
}

}  // namespace psivox
