#pragma once

#include <pybind11/numpy.h>

#include <memory>

#include "psivox/field.h"

namespace psivox::python {

namespace py = pybind11;

/// A float32 array by [x, y, z] or [x, y, z, channel].
inline ArrayValues values_in_place(const py::array& values) {
  const auto stride = [&](int axis) {
    return axis < values.ndim() ? values.strides(axis) / py::ssize_t(sizeof(float)) : 1;
  };
  return {static_cast<const float*>(values.data()), {stride(0), stride(1), stride(2), stride(3)}};
}

/// Keeps an object alive. Any thread may let go of it.
inline std::shared_ptr<const void> kept(const py::object& object) {
  return {object.inc_ref().ptr(), [](PyObject* held) {
            if (!Py_IsInitialized()) return;
            const py::gil_scoped_acquire python;
            Py_DECREF(held);
          }};
}

}  // namespace psivox::python
