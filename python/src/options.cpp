// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <set>

#include "fransac/io/sensor_json.hpp"

namespace fransac::python {
namespace {

[[noreturn]] void expected(const char* name, const std::string& what, nb::handle given) {
  raise_type_error(std::string(name) + ": expected " + what + ", got " + nb::type_name(given.type()).c_str());
}

bool is_numpy_bool(nb::handle given) {
  const std::string type = nb::type_name(given.type()).c_str();
  return type == "numpy.bool_" || type == "numpy.bool";
}

bool is_bool(nb::handle given) { return PyBool_Check(given.ptr()) || is_numpy_bool(given); }

/// A Python int; integers of NumPy are taken, too, truth values and floats are not.
nb::object integer_of(const char* name, nb::handle given) {
  if (is_bool(given) || !PyIndex_Check(given.ptr())) expected(name, "an int", given);
  return nb::steal(PyNumber_Index(given.ptr()));
}

constexpr std::string_view kSensor = "sensor";  // the one enum that a file can stand for

/// Reads a sensor.json, if that is what is given; it sets all that is known of the sensor.
bool read_sensor(nb::handle given, SensorOptions& sensor) {
  const bool word = nb::isinstance<nb::str>(given);
  if (!word && !nb::hasattr(given, "__fspath__")) return false;
  const nb::object path = nb::module_::import_("os").attr("fspath")(given);
  if (!nb::isinstance<nb::str>(path)) expected("sensor", "a str or a path", given);
  const std::filesystem::path file(nb::cast<nb::str>(path).c_str());
  if (word && file.extension() != ".json") return false;
  sensor = unwrap(io::read_sensor_json(file));
  return true;
}

constexpr std::array<std::string_view, 3> kSupports{"auto", "floor", "table"};

template <class T>
std::string type_text() {
  if constexpr (IsOptional<T>::value) {
    return type_text<typename T::value_type>() + " | None";
  } else if constexpr (std::is_same_v<T, bool>) {
    return "bool";
  } else if constexpr (std::is_same_v<T, double>) {
    return "float";
  } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
    return "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any]";
  } else if constexpr (std::is_same_v<T, SupportChoice>) {
    return literal(kSupports.data(), kSupports.size()) + " | int";
  } else if constexpr (std::is_enum_v<T>) {
    return literal(EnumNames<T>::values, std::size(EnumNames<T>::values));
  } else {
    return "int";
  }
}

std::string quoted(std::string_view word) { return "'" + std::string(word) + "'"; }

template <class T>
std::string default_text(const T& value) {
  if constexpr (IsOptional<T>::value) {
    return value ? default_text(*value) : "None";
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "True" : "False";
  } else if constexpr (std::is_same_v<T, SupportChoice>) {
    return quoted(enum_name(value.kind));
  } else if constexpr (std::is_enum_v<T>) {
    return quoted(enum_name(value));
  } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
    return "None";
  } else if constexpr (std::is_same_v<T, double>) {
    return nb::repr(nb::float_(value)).c_str();
  } else {
    return std::to_string(value);
  }
}

/// The methods that an option means something to.
constexpr std::string_view methods_text(UsedBy users) {
  switch (users) {
    case UsedBy::cells: return "cells: ";
    case UsedBy::ransac: return "all methods but cells: ";
    case UsedBy::voxel_grid: return "fransac and voxel-ransac: ";
    case UsedBy::all: break;
  }
  return "";
}

std::string help_text(const OptionInfo& info) {
  std::string help = std::string(methods_text(info.used_by)) + std::string(info.help);
  if (!info.unit.empty()) help += " [" + std::string(info.unit) + "]";
  return help;
}

bool contains(std::initializer_list<std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

template <class Options>
void names_of(std::vector<OptionInfo>& names) {
  Options options;
  visit_options(options, [&](const OptionInfo& info, auto&) { names.push_back(info); });
}

}  // namespace

std::string python_name(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

std::string in_python_names(std::string message) {
  std::vector<OptionInfo> names;
  names_of<SegmentOptions>(names);
  names_of<ObstacleOptions>(names);
  names_of<TrackOptions>(names);
  // Longer names first: one may begin another.
  std::sort(names.begin(), names.end(), [](const OptionInfo& a, const OptionInfo& b) { return a.name.size() > b.name.size(); });
  for (const OptionInfo& info : names) {
    if (!info.parameter_of.empty()) replace_all(message, std::string(info.parameter_of) + " ", "");
    if (info.name.find('-') != std::string_view::npos) replace_all(message, std::string(info.name), python_name(info.name));
  }
  return message;
}

void read_value(const char* name, nb::handle given, bool& value) {
  if (!is_bool(given)) expected(name, "a bool", given);
  value = PyObject_IsTrue(given.ptr()) == 1;
}

void read_value(const char* name, nb::handle given, int& value) {
  int overflow = 0;
  const nb::object integer = integer_of(name, given);
  const long long number = PyLong_AsLongLongAndOverflow(integer.ptr(), &overflow);
  if (overflow != 0 || number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max()) {
    raise_value_error(std::string(name) + ": " + nb::str(integer).c_str() + " is out of range");
  }
  value = static_cast<int>(number);
}

void read_value(const char* name, nb::handle given, std::uint64_t& value) {
  const nb::object integer = integer_of(name, given);
  value = PyLong_AsUnsignedLongLong(integer.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    raise_value_error(std::string(name) + ": " + nb::str(integer).c_str() + " is out of range, 0 to 2**64 - 1");
  }
}

void read_value(const char* name, nb::handle given, double& value) {
  if (PyFloat_Check(given.ptr())) {
    value = PyFloat_AsDouble(given.ptr());
    return;
  }
  const bool number = PyIndex_Check(given.ptr()) || nb::hasattr(given.type(), "__float__");
  if (!number || is_bool(given) || nb::isinstance<nb::str>(given)) expected(name, "a float", given);
  value = PyFloat_AsDouble(given.ptr());
  if (value == -1.0 && PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    expected(name, "a float", given);
  }
}

void read_value(const char* name, nb::handle given, Eigen::Vector3d& value) {
  const bool sequence = PySequence_Check(given.ptr()) && !nb::isinstance<nb::str>(given) && !nb::isinstance<nb::bytes>(given);
  if (!sequence) expected(name, "three floats", given);
  const Py_ssize_t length = PySequence_Size(given.ptr());
  if (length < 0) {
    PyErr_Clear();
    expected(name, "three floats", given);
  }
  if (length != 3) raise_value_error(std::string(name) + ": expected three floats, got " + std::to_string(length));
  for (int i = 0; i < 3; ++i) {
    const nb::object item = nb::steal(PySequence_GetItem(given.ptr(), i));
    if (!item.is_valid()) throw nb::python_error();
    read_value(name, item, value[i]);
  }
}

void read_value(const char* name, nb::handle given, SupportChoice& value) {
  if (nb::isinstance<nb::str>(given)) {
    value = {.kind = static_cast<SupportKind>(read_word(name, given, kSupports.data(), kSupports.size()))};
    return;
  }
  value = {.kind = SupportKind::plane};
  read_value(name, given, value.plane);
}

int read_word(const char* name, nb::handle given, const std::string_view* words, std::size_t count) {
  if (!nb::isinstance<nb::str>(given)) expected(name, "a str", given);
  Py_ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(given.ptr(), &size);
  if (text == nullptr) throw nb::python_error();
  const std::string_view word(text, static_cast<std::size_t>(size));
  const std::string_view* const found = std::find(words, words + count, word);
  if (found != words + count) return static_cast<int>(found - words);
  std::string list;
  for (std::size_t i = 0; i < count; ++i) list += (i == 0 ? "" : ", ") + quoted(words[i]);
  raise_value_error(std::string(name) + ": expected " + (count == 1 ? "" : "one of ") + list + ", got " +
                    nb::repr(given).c_str());
}

std::string literal(const std::string_view* words, std::size_t count) {
  std::string text = "typing.Literal[";
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + quoted(words[i]);
  return text + "]";
}

template <class Options>
Keywords<Options>::Keywords(std::initializer_list<std::string_view> only, std::initializer_list<std::string_view> without) {
  Options defaults;
  visit_options(defaults, [&](const OptionInfo& info, const auto& value) {
    using T = std::decay_t<decltype(value)>;
    const std::string name = python_name(info.name);
    const bool chosen = (only.size() == 0 || contains(only, name)) && !contains(without, name);
    names_.push_back(nb::none());
    if (!chosen) return;
    PyObject* const interned = PyUnicode_InternFromString(name.c_str());
    names_.back() = nb::steal(interned);
    std::string type = type_text<T>();
    if (name == "planes") type = "int | typing.Literal['all'] | None";
    if (name == kSensor) type += " | str | os.PathLike[str]";
    list_.push_back({name, type, default_text(value), help_text(info)});
  });
}

template <class Options>
std::size_t Keywords<Options>::read(const nb::dict& kwargs, Options& options) const {
  if (PyDict_Size(kwargs.ptr()) == 0) return 0;
  std::size_t visited = 0;
  std::size_t used = 0;
  visit_options(options, [&](const OptionInfo& info, auto& value) {
    const nb::object& name = names_[visited++];
    if (name.is_none()) return;
    PyObject* const given = PyDict_GetItemWithError(kwargs.ptr(), name.ptr());
    if (given == nullptr) return;
    ++used;
    if constexpr (std::is_same_v<Options, SegmentOptions>) {
      if (info.name == kSensor && read_sensor(given, options.sensor)) return;
    }
    read_value(nb::borrow<nb::str>(name).c_str(), given, value);
  });
  return used;
}

template class Keywords<SegmentOptions>;
template class Keywords<ObstacleOptions>;
template class Keywords<TrackOptions>;

std::string parameters(const std::vector<Keyword>& keywords) {
  std::string text;
  for (const Keyword& k : keywords) text += (text.empty() ? "" : ", ") + k.name + ": " + k.type + " = " + k.default_text;
  return text;
}

std::string descriptions(const std::vector<Keyword>& keywords) {
  std::string text;
  for (const Keyword& k : keywords) {
    text +=
        "    " + k.name + ": " + k.help + ". Default: " + (k.default_text == "None" ? "by the method" : k.default_text) + "\n";
  }
  return text;
}

void reject_unknown(const char* function, const nb::dict& kwargs, std::initializer_list<const std::vector<Keyword>*> known,
                    std::initializer_list<std::string_view> others) {
  std::set<std::string> names;
  for (const auto* list : known) {
    for (const Keyword& keyword : *list) names.insert(keyword.name);
  }
  for (const std::string_view other : others) names.emplace(other);
  for (const auto& [key, value] : kwargs) {
    const std::string name = nb::str(key).c_str();
    if (names.contains(name)) continue;
    nb::list candidates;
    for (const std::string& candidate : names) candidates.append(nb::str(candidate.c_str()));
    const nb::list close = nb::cast<nb::list>(nb::module_::import_("difflib").attr("get_close_matches")(key, candidates, 1));
    const std::string hint = close.size() == 0 ? "" : "; did you mean '" + std::string(nb::str(close[0]).c_str()) + "'?";
    raise_type_error(std::string(function) + "() has no option '" + name + "'" + hint);
  }
  raise_type_error(std::string(function) + "(): unexpected keyword arguments");
}

}  // namespace fransac::python
