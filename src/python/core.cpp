// The compiled part of the Python package: psivox/__init__.py makes it what users see.

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <variant>

#include "arrays.h"
#include "drawing.h"
#include "gl/object_counts.h"
#include "interrupt.h"
#include "psivox/dense_field.h"
#include "psivox/file_report.h"
#include "psivox/guarded_reading.h"
#include "psivox/leaf_values.h"
#include "psivox/memory.h"
#include "psivox/option_concepts.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/verify.h"

namespace psivox::python {

std::string with_keywords(const std::string& message) {
  if (message.find("--list-devices") != std::string::npos) {
    std::string text = message;
    text.replace(text.find("--list-devices"), 14, "psivox.devices()");
    return with_keywords(text);
  }
  std::string out;
  for (std::size_t i = 0; i < message.size();) {
    const bool begins = i == 0 || message[i - 1] == ' ' || message[i - 1] == '(';
    const auto is_letter = [&](std::size_t at) {
      return at < message.size() && message[at] >= 'a' && message[at] <= 'z';
    };
    if (!begins || message.compare(i, 2, "--") != 0 || !is_letter(i + 2)) {
      out += message[i++];
      continue;
    }
    for (i += 2; is_letter(i) || (i < message.size() && message[i] == '-' && is_letter(i + 1)); ++i)
      out += message[i] == '-' ? '_' : message[i];
  }
  return out;
}

namespace {

std::vector<std::string> all_with_keywords(std::vector<std::string> notices) {
  for (std::string& notice : notices) notice = with_keywords(notice);
  return notices;
}

using Floats = py::array_t<float, py::array::c_style>;
using File = std::shared_ptr<const VdbFile>;

/// Calls `report`, unless it is None, and lets Ctrl-C end the work.
Progress reporting(const py::object& report) {
  const bool reports = !report.is_none();
  return [report = report.ptr(), reports, check = SignalCheck()](double fraction) mutable {
    check();
    if (!reports) return;
    const py::gil_scoped_acquire python;
    try {
      py::reinterpret_borrow<py::object>(report)(fraction);
    } catch (py::error_already_set& error) {
      throw Stop{std::move(error)};
    }
  };
}

std::string kind_of(const Parameter& p) {
  return std::visit(
      [](auto member) -> std::string {
        using T = std::decay_t<decltype(Scene{}.*member)>;
        if constexpr (std::is_same_v<T, std::string>) return "text";
        if constexpr (std::is_same_v<T, bool>) return "flag";
        if constexpr (std::is_same_v<T, int>) return "int";
        if constexpr (std::is_same_v<T, std::uint64_t>) return "size";
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>)
          return "float";
        if constexpr (std::is_same_v<T, glm::ivec2>) return "pixels";
        if constexpr (std::is_same_v<T, std::optional<OpacityCurve>>) return "opacity";
        if constexpr (std::is_same_v<T, std::vector<DirectionalLight>>) return "lights";
        if constexpr (std::is_same_v<T, std::optional<Plane>>) return "plane";
        if constexpr (std::is_same_v<T, glm::dvec3> ||
                      std::is_same_v<T, std::optional<glm::dvec3>> ||
                      std::is_same_v<T, std::optional<MapRange>> ||
                      std::is_same_v<T, std::optional<WorldBox>>)
          return "numbers";
        return "choice";
      },
      p.member);
}

/// The table of parameters, without the input.
py::list parameter_list() {
  py::list rows;
  for (const Parameter& p : parameters()) {
    if (p.positional) continue;
    rows.append(py::dict(py::arg("name") = p.name, py::arg("metavar") = p.metavar,
                         py::arg("unit") = p.unit, py::arg("default") = p.default_text,
                         py::arg("help") = with_keywords(p.help), py::arg("unset") = p.unset,
                         py::arg("group") = group_name(p.group), py::arg("kind") = kind_of(p)));
  }
  return rows;
}

/// "; did you mean extinction?", of the names that a call takes; empty if none is near.
std::string hint(const std::string& name, const std::vector<std::string>& known) {
  std::string option = "--" + name;
  std::replace(option.begin(), option.end(), '_', '-');
  const std::string meant = with_keywords(option_of_concept(option));
  return std::find(known.begin(), known.end(), meant) == known.end()
             ? suggestion(name, known)
             : "; " + meant + " does that here";
}

/// All voxels of a grid's active box: x, y, z and, of vectors, the component.
py::array_t<float> dense_values(const VdbFile& file, const std::string& grid) {
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
  const auto channels = std::size_t(field.channels);
  float* const out = array.mutable_data();
  const auto put = [&](const glm::ivec3& voxel, const float* value) {
    const glm::ivec3 at = voxel - box.min;
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= size.x || at.y >= size.y || at.z >= size.z)
      return;
    const std::size_t index =
        (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
        std::size_t(at.z);
    std::copy_n(value, channels, out + index * channels);
  };
  run([&] {
    std::fill_n(out, std::size_t(array.size()), 0.0f);
    for (const Tile& tile : field.tiles) {
      const glm::ivec3 from = glm::max(tile.origin, box.min);
      const glm::ivec3 to = glm::min(tile.origin + (tile.width - 1), box.max);
      for (int x = from.x; x <= to.x; ++x)
        for (int y = from.y; y <= to.y; ++y)
          for (int z = from.z; z <= to.z; ++z) put({x, y, z}, &tile.value.x);
    }
    for (const Leaf& leaf : field.leaves) {
      const OrderedValues values(field, leaf);
      for (int i = 0; i < 512; ++i)
        put(leaf.origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7),
            values.data() + std::size_t(i) * channels);
    }
  });
  return array;
}

/// Any picture as the library has it: H x W x 4, or x 3 with alpha 1.
Image image_of(const Floats& pixels) {
  Image image;
  image.height = int(pixels.shape(0));
  image.width = int(pixels.shape(1));
  image.layers.push_back({"", {"R", "G", "B", "A"}, {}});
  const auto channels = std::size_t(pixels.shape(2));
  const float* value = pixels.data();
  for (py::ssize_t i = 0; i < pixels.shape(0) * pixels.shape(1); ++i, value += channels)
    for (std::size_t c = 0; c < 4; ++c)
      image.layers[0].values.push_back(c < channels ? value[c] : 1.0f);
  return image;
}

py::dict comparison_dict(const Comparison& c) {
  py::dict out(py::arg("rms") = c.rms, py::arg("max") = c.max, py::arg("max_x") = c.max_x,
               py::arg("max_y") = c.max_y, py::arg("max_channel") = c.max_channel,
               py::arg("channel_rms") = c.channel_rms, py::arg("channel_mean") = c.channel_mean,
               py::arg("not_finite") = c.not_finite);
  return out;
}

py::object plan_dict(const Picture& picture) {
  if (!picture.plan) return py::none();
  const Trial& chosen = picture.plan->chosen;
  return py::dict(py::arg("method") = method_text(chosen.method), py::arg("rms") = chosen.rms,
                  py::arg("max") = chosen.max, py::arg("reached") = picture.plan->reached);
}

py::object checked_dict(const Picture& picture) {
  if (!picture.checked) return py::none();
  const CheckedError& c = *picture.checked;
  return py::dict(py::arg("pixels") = c.pixels, py::arg("rms") = c.rms, py::arg("max") = c.max,
                  py::arg("max_x") = c.max_x, py::arg("max_y") = c.max_y);
}

/// A layer's values as an array that keeps the picture alive.
py::array layer_array(const py::object& self, std::size_t number) {
  const auto& picture = self.cast<const Picture&>();
  const Layer& layer = picture.image.layers[number];
  std::vector<py::ssize_t> shape{picture.image.height, picture.image.width};
  if (layer.channels.size() > 1) shape.push_back(py::ssize_t(layer.channels.size()));
  py::array_t<float> array(shape, layer.values.data(), self);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

void define_errors(py::module_& m) {
  static py::handle error_type =
      PyErr_NewExceptionWithDoc("psivox.Error",
                                "What went wrong, in one line. `exit_code` is the one with which "
                                "the program `psivox` ends.",
                                PyExc_RuntimeError, nullptr);
  m.attr("Error") = error_type;
  error_type.attr("exit_code") = 1;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& error) {
      py::object exception = error_type(with_keywords(error.what()));
      exception.attr("exit_code") = int(error.code());
      PyErr_SetObject(error_type.ptr(), exception.ptr());
    }
  });
}

void define_grids(py::module_& m) {
  py::class_<VdbFile, std::shared_ptr<VdbFile>>(m, "File")
      .def(py::init([](const std::string& path) {
        const Progress interruptible = reporting(py::none());
        return run([&] { return std::make_shared<VdbFile>(path, interruptible); });
      }))
      .def_property_readonly("names", &VdbFile::names)
      .def("channels", &VdbFile::channels)
      .def("default_grid",
           [](const VdbFile& file) { return run([&] { return file.default_grid(); }); })
      .def("values", &dense_values)
      .def("place", [](const VdbFile& file, const std::string& name) -> py::object {
        const auto rows = run([&] { return file.info(false); });
        for (const GridInfo& row : rows) {
          if (row.name != name) continue;
          py::list matrix;
          for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c) matrix.append(row.world_from_index[c][r]);
          const auto three = [](const auto& v) { return py::make_tuple(v.x, v.y, v.z); };
          return py::dict(
              py::arg("min") = three(row.active_box.min),
              py::arg("max") = three(row.active_box.max),
              py::arg("voxel_size") = three(row.voxel_size), py::arg("world_from_index") = matrix,
              py::arg("active_voxels") = row.active_voxels, py::arg("value_type") = row.value_type);
        }
        return py::none();
      });
  m.def(
      "gather",
      [](const std::vector<std::tuple<std::string, std::shared_ptr<VdbFile>, std::string>>& grids) {
        return run([&] {
          std::vector<NamedGrid> named;
          for (const auto& [name, file, grid] : grids) named.push_back({name, file, grid});
          return std::make_shared<VdbFile>(std::move(named));
        });
      });
  py::class_<DenseField>(m, "DenseField")
      .def(py::init([](const std::string& name, const std::array<int, 3>& shape, int channels,
                       const std::array<double, 3>& voxel_size,
                       const std::array<double, 3>& origin) {
        glm::dmat4 place = glm::translate(glm::dmat4(1), {origin[0], origin[1], origin[2]});
        place = glm::scale(place, {voxel_size[0], voxel_size[1], voxel_size[2]});
        return DenseField(name, {shape[0], shape[1], shape[2]}, channels, place);
      }))
      .def("add",
           [](DenseField& field, const Floats& slab) {
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
          return std::make_shared<VdbFile>(std::make_shared<const Field>(field.finish()));
        });
      });
  m.def("info",
        [](const std::string& path) { return run([&] { return report_of(path).json(); }); });
}

void define_pictures(py::module_& m) {
  py::class_<SceneWords>(m, "SceneWords")
      .def(py::init<>())
      .def_readwrite("base", &SceneWords::base)
      .def_readwrite("base_file", &SceneWords::base_file)
      .def_readwrite("camera", &SceneWords::camera)
      .def_readwrite("settings", &SceneWords::settings);
  py::class_<Picture>(m, "Image", py::buffer_protocol())
      .def_buffer([](Picture& picture) {
        const Image& image = picture.image;
        const py::ssize_t width = image.width;
        return py::buffer_info(const_cast<float*>(image.rgba().data()), sizeof(float),
                               py::format_descriptor<float>::format(), 3,
                               {py::ssize_t(image.height), width, py::ssize_t(4)},
                               {width * 16, py::ssize_t(16), py::ssize_t(4)}, /*readonly=*/true);
      })
      .def_property_readonly("width", [](const Picture& p) { return p.image.width; })
      .def_property_readonly("height", [](const Picture& p) { return p.image.height; })
      .def_property_readonly("_layers",
                             [](const Picture& p) {
                               std::vector<std::string> names;
                               for (const Layer& layer : p.image.layers)
                                 names.push_back(layer.name);
                               return names;
                             })
      .def("_layer", &layer_array)
      .def_property_readonly("notices",
                             [](const Picture& p) { return all_with_keywords(p.notices); })
      .def_readonly("renderer", &Picture::renderer)
      .def_property_readonly("_scene", [](const Picture& p) { return to_json(p.scene); })
      .def_property_readonly("estimate", &plan_dict)
      .def_property_readonly("checked", &checked_dict)
      .def("_write",
           [](const Picture& picture, const std::string& path, bool half, std::optional<int> bits) {
             return all_with_keywords(
                 run([&] { return write(picture, path, {.half = half, .bits = bits}); }));
           });
  py::class_<Drawing>(m, "Drawing")
      .def(py::init([](const std::shared_ptr<VdbFile>& file, const SceneWords& words) {
        return run([&] { return std::make_unique<Drawing>(file, words); });
      }))
      .def("draw",
           [](Drawing& drawing, const SceneWords& words, const std::vector<std::string>& layers,
              std::optional<double> budget, int check_error, const py::object& report) {
             const PictureWords wanted{layers, budget, check_error};
             const Progress progress = reporting(report);
             return run(
                 [&] { return std::make_unique<Picture>(drawing.draw(words, wanted, progress)); });
           })
      .def("close", [](Drawing& drawing) { run([&] { drawing.close(); }); });
}

void define_studies(py::module_& m) {
  m.def("sweep_lists", &sweep_lists);
  m.def("swept_parameters", &swept_parameters);
  m.def("study", [](const std::shared_ptr<VdbFile>& file, const SceneWords& words,
                    const std::string& folder, const std::map<std::string, std::string>& lists,
                    int repeats, bool split, bool resume, const py::object& report) {
    const Progress progress = reporting(report);
    return run([&] {
      StudyOptions options;
      options.folder = folder;
      for (const auto& [name, text] : lists) set_sweep(options.sweep, name, text);
      options.repeats = repeats;
      options.split = split;
      options.resume = resume;
      options.progress = progress;
      check_study_folder(folder, resume);
      return run_study(study_view(*file, words), options);
    });
  });
  m.def("verify", [](const std::string& filter, int device) {
    const VerifyReport report = run([&] {
      Scene scene;
      set_parameter(scene, "filter", filter);
      return verify({.filter = scene.filter,
                     .device = device,
                     .progress = [check = SignalCheck()](const VerifyCase&) mutable { check(); }});
    });
    py::list rows;
    for (const VerifyCase& c : report.cases)
      rows.append(py::dict(py::arg("name") = c.name, py::arg("error") = c.error,
                           py::arg("bound") = c.bound, py::arg("reason") = c.reason,
                           py::arg("passed") = c.passed()));
    return rows;
  });
  m.def("devices", [] {
    const std::vector<DeviceInfo> found = run([] { return list_devices(); });
    py::list rows;
    for (const DeviceInfo& d : found)
      rows.append(py::dict(py::arg("index") = d.index, py::arg("renderer") = d.renderer,
                           py::arg("version") = d.version, py::arg("problem") = d.problem,
                           py::arg("software") = d.software));
    return rows;
  });
  m.def("compare",
        [](const std::variant<std::string, Floats>& a, const std::variant<std::string, Floats>& b) {
          const auto image = [](const auto& source) {
            if (const auto* pixels = std::get_if<Floats>(&source)) return image_of(*pixels);
            return run([&] { return read_image(std::get<std::string>(source)); });
          };
          const Image left = image(a), right = image(b);
          return comparison_dict(run([&] { return compare_images(left, right); }));
        });
  m.def("read_picture", [](const std::string& path) {
    const Image image = run([&] { return read_image(path); });
    py::array_t<float> array({py::ssize_t(image.height), py::ssize_t(image.width), py::ssize_t(4)});
    std::copy(image.rgba().begin(), image.rgba().end(), array.mutable_data());
    return array;
  });
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  define_errors(m);
  define_grids(m);
  define_pictures(m);
  define_studies(m);
  m.attr("version") = PSIVOX_VERSION;
  m.attr("layer_names") = layer_names();
  m.def("parameters", &parameter_list);
  m.def("hint", &hint);
  m.def("start_guarded_reading",
        [](const std::string& server) { run([&] { start_guarded_reading(server); }); });
  m.def("trust_files", &trust_files);
  m.def("reading_guard", &reading_guard);
  m.def("fail", [](int code, const std::string& message) {
    throw Error(static_cast<ExitCode>(code), message);
  });
  // for tests, in a call of `progress`: there a context is current
  m.def("gl_objects", [] {
    const gl::ObjectCounts n = gl::count_objects();
    return std::array{n.textures, n.buffers,       n.framebuffers, n.programs,
                      n.shaders,  n.vertex_arrays, n.queries};
  });
  m.def("close", [] { marchers().close(); });
}

}  // namespace psivox::python
