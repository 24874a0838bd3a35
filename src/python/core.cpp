// The compiled part of the Python package: psivox/__init__.py makes it what users see.

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <variant>

#include "app/command_text.h"
#include "base/text.h"
#include "base/text_file.h"
#include "core.h"
#include "gl/gl_renderer.h"
#include "psivox/parameters.h"
#include "psivox/study.h"
#include "psivox/vdb.h"
#include "psivox/verify.h"
#include "scene/color.h"

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

namespace {

std::vector<std::string> all_with_keywords(std::vector<std::string> notices) {
  for (std::string& notice : notices) notice = with_keywords(notice);
  return notices;
}

using Floats = py::array_t<float, py::array::c_style>;

std::string kind_of(const Parameter& p) {
  if (takes_grey(p)) return "grey";
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
        if constexpr (std::is_same_v<T, std::vector<std::string>>) return "texts";
        if constexpr (std::is_same_v<T, std::optional<Plane>>) return "plane";
        if constexpr (std::is_same_v<T, glm::dvec3> ||
                      std::is_same_v<T, std::optional<glm::dvec3>> ||
                      std::is_same_v<T, std::optional<Background>> ||
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
                         py::arg("unit") = p.unit,
                         py::arg("default") = with_keywords(p.default_text),
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
  return std::ranges::count(known, meant) ? "; " + meant + " does that here"
                                          : suggestion(name, known);
}

/// Any picture as the library has it: H x W x 4, or x 3 with alpha 1.
Image image_of(const Floats& pixels) {
  Image image = rgba_image(int(pixels.shape(1)), int(pixels.shape(0)), 1);
  const auto channels = std::size_t(pixels.shape(2));
  const float* value = pixels.data();
  for (std::size_t i = 0; i < image.rgba().size(); i += 4, value += channels)
    std::copy_n(value, channels, &image.rgba()[i]);
  return image;
}

py::dict comparison_dict(const Comparison& c) {
  return py::dict(py::arg("rms") = c.rms, py::arg("max") = c.max, py::arg("max_x") = c.max_x,
                  py::arg("max_y") = c.max_y, py::arg("max_channel") = c.max_channel,
                  py::arg("channel_rms") = c.channel_rms, py::arg("channel_mean") = c.channel_mean,
                  py::arg("not_finite") = c.not_finite);
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

/// Samples of each pixel, and their Z, ZBack, R, G, B and A, as arrays that keep the picture alive.
py::tuple deep_arrays(const py::object& self) {
  const Image& image = self.cast<const Picture&>().image;
  const DeepPixels& deep = image.deep;
  py::array_t<std::uint32_t> counts({image.height, image.width}, deep.counts.data(), self);
  py::array_t<float> samples({py::ssize_t(deep.samples.size()), py::ssize_t(6)},
                             reinterpret_cast<const float*>(deep.samples.data()), self);
  for (const py::array& array : {py::array(counts), py::array(samples)})
    array.attr("setflags")(py::arg("write") = false);
  return py::make_tuple(counts, samples);
}

/// Text that may hold the name of a file, whose bytes need not be UTF-8.
py::object text_of(const std::string& bytes) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "surrogateescape"));
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
      py::object exception = error_type(text_of(printable(with_keywords(error.what()))));
      exception.attr("exit_code") = int(error.code());
      PyErr_SetObject(error_type.ptr(), exception.ptr());
    }
  });
}

void define_pictures(py::module_& m) {
  py::class_<SceneWords>(m, "SceneWords")
      .def(py::init<>())
      .def_readwrite("base", &SceneWords::base)
      .def_readwrite("base_file", &SceneWords::base_file)
      .def_readwrite("camera", &SceneWords::camera)
      .def_readwrite("settings", &SceneWords::settings);
  py::class_<Picture>(m, "Image", py::buffer_protocol(), py::dynamic_attr())
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
                               if (!p.image.deep.counts.empty()) names.emplace_back("deep");
                               return names;
                             })
      .def("_layer", &layer_array)
      .def("_deep", &deep_arrays)
      .def_property_readonly("notices",
                             [](const Picture& p) { return all_with_keywords(p.notices); })
      .def_readonly("renderer", &Picture::renderer)
      .def_property_readonly("_scene", [](const Picture& p) { return to_json(p.scene); })
      .def_property_readonly("estimate", &plan_dict)
      .def_property_readonly("checked", &checked_dict)
      .def_property_readonly("_background",
                             [](const Picture& p) -> std::optional<std::array<double, 3>> {
                               if (!p.look_background) return {};
                               const glm::dvec3& color = p.look_background->color;
                               return std::array{color.x, color.y, color.z};
                             })
      .def_property_readonly("_page", [](const Picture& p) { return py::bytes(p.page); })
      .def("_write",
           [](const Picture& picture, const std::string& path, bool half, std::optional<int> bits) {
             return all_with_keywords(
                 run([&] { return write(picture, path, {.half = half, .bits = bits}); }));
           });
}

void define_drawings(py::module_& m) {
  py::class_<Drawing>(m, "Drawing")
      .def(py::init([](const std::shared_ptr<VolumeFile>& file, const SceneWords& words) {
        return run([&] { return std::make_unique<Drawing>(file, words); });
      }))
      .def("draw",
           [](Drawing& drawing, const SceneWords& words, const std::vector<std::string>& layers,
              int check_error, const py::object& report,
              const std::optional<std::pair<std::string, double>>& page) {
             PictureWords wanted{layers, check_error};
             if (page) wanted.page = PageOptions{page->first, page->second};
             const Progress progress = reporting(report);
             return run(
                 [&] { return std::make_unique<Picture>(drawing.draw(words, wanted, progress)); });
           })
      .def("close", [](Drawing& drawing) { run([&] { drawing.close(); }); });
}

void define_drivers(py::module_& m) {
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
}

void define_studies(py::module_& m) {
  m.def("sweep_lists", [] { return names_in(sweep_lists(), &SweepList::name); });
  m.def("swept_parameters", &swept_parameters);
  m.def("study", [](const std::shared_ptr<VolumeFile>& file, const SceneWords& words,
                    const std::string& folder, const std::map<std::string, std::string>& lists,
                    const std::vector<std::tuple<std::string, std::string, double>>& foreign,
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
      options.stop = [check = SignalCheck()]() mutable {
        check();
        return false;
      };
      for (const auto& [name, picture, time_ms] : foreign)
        options.foreign.push_back({name, picture, time_ms});
      check_study_folder(folder, resume);
      return run_study(study_view(*file, words), options);
    });
  });
  m.def("write_text", [](const std::string& path, const std::string& text) {
    run([&] { write_text(path, text); });
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
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  define_errors(m);
  define_grids(m);
  define_pictures(m);
  define_drawings(m);
  define_drivers(m);
  define_studies(m);
  m.attr("version") = PSIVOX_VERSION;
  m.attr("layer_names") = layer_names();
  m.def("parameters", &parameter_list);
  m.def("hint", &hint);
  m.def("start_guarded_reading",
        [](const std::string& server) { run([&] { start_guarded_reading(server); }); });
  m.def(
      "trust_files", [] { trust_files(); },
      "Reads files in this process from now on, without its guard: only for files of your own.");
  m.def("reading_guard", &reading_guard);
  m.def("fail", [](int code, const std::string& message) {
    throw Error(static_cast<ExitCode>(code), message);
  });
  // for tests, in a call of `progress`: there a context is current
  m.def("gl_objects", &gl::count_objects);
  m.def("close", [] {
    Working::end();
    close_marchers();
  });
}

}  // namespace psivox::python
