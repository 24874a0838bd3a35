// What the Python package does with grids: it reads files and makes volumes of arrays.

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>

#include "base/memory.h"
#include "base/text.h"
#include "core.h"
#include "psivox/field.h"
#include "psivox/file_report.h"

namespace psivox::python {
namespace {

using Slab = py::array_t<float, py::array::c_style>;

/// A float32 array by [x, y, z] or [x, y, z, channel].
ArrayValues values_in_place(const py::array& values) {
  const auto stride = [&](int axis) {
    return axis < values.ndim() ? values.strides(axis) / py::ssize_t(sizeof(float)) : 1;
  };
  return {static_cast<const float*>(values.data()), {stride(0), stride(1), stride(2), stride(3)}};
}

/// Keeps an object alive. Any thread may let go of it.
std::shared_ptr<const void> kept(const py::object& object) {
  return {object.inc_ref().ptr(), [](PyObject* held) {
            if (!Py_IsInitialized()) return;
            const py::gil_scoped_acquire python;
            Py_DECREF(held);
          }};
}

/// All voxels of a grid's active box: x, y, z and, of vectors, the component.
py::array_t<float> dense_values(const VolumeFile& file, const std::string& grid) {
  const Field field = run([&] { return file.read(grid, {.role = GridRole::data}); });
  const Box& box = field.active_box;
  const glm::ivec3 size = box.max - box.min + 1;
  const double bytes = 4.0 * size.x * size.y * size.z * field.channels;
  if (const std::uint64_t free = available_memory(); free > 0 && bytes > double(free))
    throw Error(ExitCode::memory, "grid " + in_quotes(grid) +
                                      formatted(" of %dx%dx%d voxels is too large to be dense in "
                                                "the memory that is free",
                                                size.x, size.y, size.z));
  std::vector<py::ssize_t> shape{size.x, size.y, size.z};
  if (field.channels == 3) shape.push_back(3);
  py::array_t<float> array(shape);
  float* const out = array.mutable_data();
  run([&] { write_dense(field, box, out); });
  return array;
}

/// Where a grid lies, as a dict; None: there is no such grid.
py::object place_of(const VolumeFile& file, const std::string& name) {
  const auto rows = run([&] { return file.info(false); });
  for (const GridInfo& row : rows) {
    if (row.name != name && row.name != name + "[0]") continue;  // of several, the first
    py::list matrix;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) matrix.append(row.world_from_index[c][r]);
    const auto three = [](const auto& v) { return py::make_tuple(v.x, v.y, v.z); };
    return py::dict(
        py::arg("min") = three(row.active_box.min), py::arg("max") = three(row.active_box.max),
        py::arg("voxel_size") = three(row.voxel_size), py::arg("world_from_index") = matrix,
        py::arg("active_voxels") = row.active_voxels, py::arg("value_type") = row.value_type);
  }
  return py::none();
}

}  // namespace

void define_grids(py::module_& m) {
  py::class_<VolumeFile, std::shared_ptr<VolumeFile>>(m, "File")
      .def(py::init([](const std::string& path) {
        const Progress interruptible = reporting(py::none());
        return run([&] { return std::make_shared<VolumeFile>(path, interruptible); });
      }))
      .def_property_readonly("names", &VolumeFile::names)
      .def("channels", &VolumeFile::channels)
      .def("default_grid",
           [](const VolumeFile& file) { return run([&] { return file.default_grid(); }); })
      .def("values", &dense_values)
      .def("place", &place_of);
  m.def("gather",
        [](const std::vector<std::tuple<std::string, std::shared_ptr<VolumeFile>, std::string>>&
               grids) {
          return run([&] {
            std::vector<NamedGrid> named;
            for (const auto& [name, file, grid] : grids) named.push_back({name, file, grid});
            return std::make_shared<VolumeFile>(std::move(named));
          });
        });
  py::class_<DenseField>(m, "DenseField")
      .def(py::init([](const std::string& name, const std::array<int, 3>& shape, int channels,
                       const std::array<double, 12>& rows) {
        glm::dmat4 place(1);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 4; ++c) place[c][r] = rows[std::size_t(4 * r + c)];
        return DenseField(name, {shape[0], shape[1], shape[2]}, channels, place);
      }))
      .def("add",
           [](DenseField& field, const Slab& slab) {
             const std::span<const float> values(slab.data(), std::size_t(slab.size()));
             run([&] { field.add(values); });
           })
      .def("hold",
           [](DenseField& field, const py::array& values) {
             const ArrayValues array = values_in_place(values);
             std::shared_ptr<const void> owner = kept(values);
             run([&] { field.hold(array, std::move(owner)); });
           })
      .def("finish", [](DenseField& field) {
        return run([&] {
          return std::make_shared<VolumeFile>(std::make_shared<const Field>(field.finish()));
        });
      });
  m.def("info",
        [](const std::string& path) { return run([&] { return report_of(path).json(); }); });
}

}  // namespace psivox::python
