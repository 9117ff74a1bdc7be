// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/camera_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>
#include <vector>

#include "io/guard.h"
#include "io/json.h"
#include "io/read_text.h"
#include "io/text.h"
#include "io/yaml.h"

namespace fransac::io {
namespace {

constexpr std::size_t kMaxCameraBytes = std::size_t{1} << 20;  // a few numbers and whatever else a tool may keep there

/// A file's content, and its name for messages.
struct Source {
  const Json& object;
  const std::string& name;

  [[nodiscard]] bool has(const char* field) const { return object.find(field) != nullptr; }
};

/// What a field is called in each kind of file.
struct FieldNames {
  const char* width;
  const char* height;
  const char* fx;
  const char* fy;
  const char* cx;
  const char* cy;
};

Error field_error(const Source& source, std::string_view field, std::string_view what) {
  return io::field_error(source.name, field, what);
}

Status read_size(const Source& source, const char* width, const char* height, Camera& camera) {
  for (const auto& [field, value] : {std::pair{width, &camera.width}, std::pair{height, &camera.height}}) {
    const Result<int> read = whole_field(source.object, field, field, kMaxImageSide, source.name);
    if (!read) return read.error();
    *value = *read;
  }
  return {};
}

Status read_number(const Source& source, const char* field, double& value) {
  const Result<double> read = number_field(source.object, field, field, source.name);
  if (!read) return read.error();
  value = *read;
  return {};
}

/// A camera whose numbers are fields of their own.
Status read_fields(const Source& source, const FieldNames& names, Camera& camera) {
  if (Status status = read_size(source, names.width, names.height, camera); !status) return status;
  for (const auto& [field, value] : {std::pair{names.fx, &camera.fx}, std::pair{names.fy, &camera.fy},
                                     std::pair{names.cx, &camera.cx}, std::pair{names.cy, &camera.cy}}) {
    if (Status status = read_number(source, field, *value); !status) return status;
  }
  return {};
}

/// The numbers of an array; `label` names it in messages.
Result<std::vector<double>> numbers_of(const Source& source, const Json* array, std::string_view label) {
  if (array == nullptr) return field_error(source, label, "is missing");
  if (array->elements() == nullptr) return field_error(source, label, std::string("must be an array, not ") + array->type_name());
  std::vector<double> numbers;
  for (const Json& element : *array->elements()) {
    const std::optional<double> number = element.number();
    if (!number) return field_error(source, label, std::string("must hold numbers only, not ") + element.type_name());
    numbers.push_back(*number);
  }
  return numbers;
}

/// The same of what OpenCV and ROS write as rows, cols and data.
Result<std::vector<double>> matrix_of(const Source& source, const char* field) {
  const Json* const matrix = source.object.find(field);
  if (matrix == nullptr) return field_error(source, field, "is missing");
  return numbers_of(source, matrix->find("data"), std::string(field) + ".data");
}

/// `matrix` is (fx 0 cx; 0 fy cy; 0 0 1), row by row.
Status use_matrix(const Source& source, const std::string& label, const std::vector<double>& matrix, const char* order,
                  Camera& camera) {
  if (matrix.size() != 9 || matrix[1] != 0.0 || matrix[3] != 0.0 || matrix[6] != 0.0 || matrix[7] != 0.0 || matrix[8] != 1.0) {
    return field_error(source, label, std::string("must hold the numbers ") + order);
  }
  camera.fx = matrix[0];
  camera.fy = matrix[4];
  camera.cx = matrix[2];
  camera.cy = matrix[5];
  return {};
}

bool all_zero(const std::vector<double>& coefficients) {
  return std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return c == 0.0; });
}

Error unknown_lens(const Source& source, std::string_view model, std::size_t coefficients) {
  return file_error(
      ErrorCode::format, source.name,
      "lens distortion " + quoted_text(model) + " with " + std::to_string(coefficients) +
          " coefficients is not known (plumb_bob, rational_polynomial and equidistant are); rectify the depth first");
}

/// A lens of OpenCV's models; nothing where it does not distort.
Result<std::optional<Lens>> lens_of(const Source& source, const std::string& model, const std::vector<double>& coefficients) {
  if (all_zero(coefficients)) return std::optional<Lens>();
  Lens lens;
  std::size_t known = 0;
  if (model == "equidistant" || model == "fisheye") {
    lens.model = LensModel::equidistant;
    known = 4;
  } else if (model == "rational_polynomial") {
    lens.model = LensModel::rational_polynomial;
    known = 8;
  } else if (model == "plumb_bob") {
    lens.model = LensModel::plumb_bob;
    known = 5;
  }
  // Further coefficients, as those of thin prisms and tilted sensors, may stand there if they are zero.
  const auto first_unknown = coefficients.begin() + static_cast<std::ptrdiff_t>(std::min(known, coefficients.size()));
  if (std::any_of(first_unknown, coefficients.end(), [](double c) { return c != 0.0; })) {
    return unknown_lens(source, model, coefficients.size());
  }
  std::copy(coefficients.begin(), first_unknown, lens.coefficients.begin());
  return std::optional(lens);
}

Result<std::string> model_of(const Source& source, const char* field, const char* otherwise) {
  const Json* const found = source.object.find(field);
  if (found == nullptr) return std::string(otherwise);
  if (found->string() == nullptr) return field_error(source, field, std::string("must be a string, not ") + found->type_name());
  return *found->string();
}

Status read_lens(const Source& source, const std::string& model, const std::vector<double>& coefficients, CameraFile& file) {
  Result<std::optional<Lens>> lens = lens_of(source, model, coefficients);
  if (!lens) return lens.error();
  file.lens = *lens;
  return {};
}

constexpr const char* kRowByRow = "fx 0 cx 0 fy cy 0 0 1";

/// OpenCV takes more than five coefficients for the rational model's where no model is named.
const char* model_for(std::size_t coefficients) { return coefficients > 5 ? "rational_polynomial" : "plumb_bob"; }

Status read_ros_calibration(const Source& source, CameraFile& file) {
  if (Status status = read_size(source, "image_width", "image_height", file.camera); !status) return status;
  const Result<std::vector<double>> matrix = matrix_of(source, "camera_matrix");
  if (!matrix) return matrix.error();
  if (Status status = use_matrix(source, "camera_matrix.data", *matrix, kRowByRow, file.camera); !status) return status;
  const bool distorted = source.has("distortion_coefficients");
  const auto coefficients = distorted ? matrix_of(source, "distortion_coefficients") : std::vector<double>();
  if (!coefficients) return coefficients.error();
  const Result<std::string> model = model_of(source, "distortion_model", model_for(coefficients->size()));
  if (!model) return model.error();
  return read_lens(source, *model, *coefficients, file);
}

/// Binning and a region of interest make another camera of the one that the message describes.
Status check_whole_image(const Source& source, const Camera& camera) {
  for (const char* const field : {"binning_x", "binning_y"}) {
    const Json* const binning = source.object.find(field);
    if (binning != nullptr && binning->number().value_or(0.0) > 1.0)
      return field_error(source, field, "above 1 is not supported");
  }
  const Json* const region = source.object.find("roi");
  if (region == nullptr) return {};
  const auto number = [&](const char* field) {
    const Json* const found = region->find(field);
    return found == nullptr ? 0.0 : found->number().value_or(0.0);
  };
  const bool is_whole = (number("width") == 0.0 || number("width") == camera.width) &&
                        (number("height") == 0.0 || number("height") == camera.height) && number("x_offset") == 0.0 &&
                        number("y_offset") == 0.0;
  return is_whole ? Status() : field_error(source, "roi", "other than the whole image is not supported");
}

Status read_ros_message(const Source& source, CameraFile& file) {
  const char* const k = source.has("K") ? "K" : "k";
  const char* const d = source.has("D") ? "D" : "d";
  if (Status status = read_size(source, "width", "height", file.camera); !status) return status;
  const Result<std::vector<double>> matrix = numbers_of(source, source.object.find(k), k);
  if (!matrix) return matrix.error();
  if (Status status = use_matrix(source, k, *matrix, kRowByRow, file.camera); !status) return status;
  if (Status status = check_whole_image(source, file.camera); !status) return status;
  const auto coefficients = source.has(d) ? numbers_of(source, source.object.find(d), d) : std::vector<double>();
  if (!coefficients) return coefficients.error();
  const Result<std::string> model = model_of(source, "distortion_model", model_for(coefficients->size()));
  if (!model) return model.error();
  return read_lens(source, *model, *coefficients, file);
}

Status read_intrinsic_matrix(const Source& source, CameraFile& file) {
  if (Status status = read_size(source, "width", "height", file.camera); !status) return status;
  const auto columns = numbers_of(source, source.object.find("intrinsic_matrix"), "intrinsic_matrix");
  if (!columns) return columns.error();
  std::vector<double> rows = *columns;
  if (rows.size() == 9) {
    std::swap(rows[1], rows[3]);
    std::swap(rows[2], rows[6]);
    std::swap(rows[5], rows[7]);
  }
  return use_matrix(source, "intrinsic_matrix", rows, "fx 0 0 0 fy 0 cx cy 1, column by column", file.camera);
}

Status read_open3d(const Source& source, CameraFile& file) {
  if (const Json* const intrinsic = source.object.find("intrinsic"))
    return read_intrinsic_matrix({*intrinsic, source.name}, file);
  return read_intrinsic_matrix(source, file);
}

/// A trajectory has a camera for each pose: all must be one.
Status read_open3d_trajectory(const Source& source, CameraFile& file) {
  const Json::Array* const all = source.object.find("parameters")->elements();
  if (all == nullptr || all->empty()) return field_error(source, "parameters", "holds no camera");
  for (const Json& parameters : *all) {
    CameraFile one;
    if (Status status = read_open3d({parameters, source.name}, one); !status) return status;
    if (&parameters != all->data() && one != file) return field_error(source, "parameters", "holds several cameras");
    file = one;
  }
  return {};
}

/// The name of a RealSense's model without prefix, case and blanks: the SDK and its tools spell it in several ways.
std::string realsense_model(const std::string& name) {
  std::string model = name.substr(name.rfind('.') == std::string::npos ? 0 : name.rfind('.') + 1);
  for (char& c : model) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return model;
}

Status read_realsense(const Source& source, CameraFile& file) {
  if (Status status = read_fields(source, {"width", "height", "fx", "fy", "ppx", "ppy"}, file.camera); !status) return status;
  const auto coefficients =
      source.has("coeffs") ? numbers_of(source, source.object.find("coeffs"), "coeffs") : std::vector<double>();
  if (!coefficients) return coefficients.error();
  // rs2_distortion as a number.
  constexpr std::array<const char*, 6> kByNumber{"none",   "modified_brown_conrady", "inverse_brown_conrady",
                                                 "ftheta", "brown_conrady",          "kannala_brandt4"};
  const Json* const field = source.object.find("model");
  const std::optional<double> number = field != nullptr ? field->number() : std::nullopt;
  const bool is_index = number && *number >= 0.0 && *number < static_cast<double>(kByNumber.size());
  const Result<std::string> name =
      is_index ? std::string(kByNumber[static_cast<std::size_t>(*number)]) : model_of(source, "model", "no model");
  if (!name) return name.error();
  const std::string model = realsense_model(*name);
  if (model == "none") return {};
  if (model == "brown_conrady") return read_lens(source, "plumb_bob", *coefficients, file);
  if (model == "kannala_brandt4") return read_lens(source, "equidistant", *coefficients, file);
  return read_lens(source, *name, *coefficients, file);
}

Status read_orb_slam(const Source& source, const std::string& prefix, CameraFile& file) {
  const auto field = [&](const char* name) { return prefix + "." + name; };
  const std::string fx = field("fx");
  const std::string fy = field("fy");
  const std::string cx = field("cx");
  const std::string cy = field("cy");
  const FieldNames names{"Camera.width", "Camera.height", fx.c_str(), fy.c_str(), cx.c_str(), cy.c_str()};
  if (Status status = read_fields(source, names, file.camera); !status) return status;
  for (const char* const factor : {"DepthMapFactor", "RGBD.DepthMapFactor"}) {
    if (!source.has(factor)) continue;
    if (Status status = read_number(source, factor, file.camera.depth_scale); !status) return status;
  }
  const Result<std::string> type = model_of(source, "Camera.type", "PinHole");
  if (!type) return type.error();
  const bool fisheye = *type == "KannalaBrandt8";
  const std::vector<const char*> order =
      fisheye ? std::vector{"k1", "k2", "k3", "k4"} : std::vector{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  std::vector<double> coefficients;
  for (const char* const name : order) {
    coefficients.push_back(0.0);
    if (!source.has(field(name).c_str())) continue;
    if (Status status = read_number(source, field(name).c_str(), coefficients.back()); !status) return status;
  }
  if (fisheye) return read_lens(source, "equidistant", coefficients, file);
  const bool rational = !all_zero({coefficients.begin() + 5, coefficients.end()});
  return read_lens(source,
                   *type != "PinHole" && *type != "Rectified" ? *type
                   : rational                                 ? "rational_polynomial"
                                                              : "plumb_bob",
                   coefficients, file);
}

/// A field that only one kind of file has, and the reader of that kind.
struct Kind {
  const char* field;
  Status (*read)(const Source&, CameraFile&);
};
constexpr std::array<Kind, 9> kKinds{{
    {"camera_matrix", &read_ros_calibration},
    {"K", &read_ros_message},
    {"k", &read_ros_message},
    {"intrinsic_matrix", &read_open3d},
    {"intrinsic", &read_open3d},
    {"parameters", &read_open3d_trajectory},
    {"ppx", &read_realsense},
    {"Camera.fx", [](const Source& source, CameraFile& file) { return read_orb_slam(source, "Camera", file); }},
    {"Camera1.fx", [](const Source& source, CameraFile& file) { return read_orb_slam(source, "Camera1", file); }},
}};

bool is_own(const Source& source) {
  constexpr std::array<const char*, 4> kFields{"fx", "fy", "cx", "cy"};
  return std::count_if(kFields.begin(), kFields.end(), [&](const char* field) { return source.has(field); }) > 1;
}

Status read_kind(const Source& source, CameraFile& file) {
  // A RealSense's file has fx and fy as well.
  if (!source.has("ppx") && is_own(source)) {
    return read_fields(source, {"width", "height", "fx", "fy", "cx", "cy"}, file.camera);
  }
  for (const Kind& kind : kKinds) {
    if (source.has(kind.field)) return kind.read(source, file);
  }
  return file_error(ErrorCode::format, source.name,
                    "no known camera: neither fx, fy, cx and cy (camera.json) nor camera_matrix, K or k (ROS), intrinsic_matrix "
                    "(Open3D), ppx and ppy (RealSense), Camera.fx or Camera1.fx (ORB-SLAM)");
}

Result<CameraFile> camera_of(const Json& object, const std::string& name) {
  const Source source{object, name};
  CameraFile file;
  if (Status status = read_kind(source, file); !status) return status.error();
  if (source.has("depth_scale")) {
    if (Status status = read_number(source, "depth_scale", file.camera.depth_scale); !status) return status.error();
  }
  if (const Status status = validate(file.camera); !status) return file_error(ErrorCode::format, name, status.error().message);
  return file;
}

Result<Json> parse_object(std::string_view text, const std::string& name) {
  const std::string_view start = text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  const bool is_json = first != std::string_view::npos && (start[first] == '{' || start[first] == '[');
  return is_json ? parse_json_object(text, name) : parse_yaml_object(text, name);
}

}  // namespace

Result<CameraFile> parse_camera_file(std::string_view text, const std::string& name) {
  return guarded(name, [&]() -> Result<CameraFile> {
    const Result<Json> object = parse_object(text, name);
    if (!object) return object.error();
    return camera_of(*object, name);
  });
}

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
  return guarded(file.native(), [&] { return read_text(file, kMaxCameraBytes, &parse_camera_file); });
}

Result<Camera> pinhole_of(const CameraFile& file, const std::string& name) {
  return guarded(name, [&]() -> Result<Camera> {
    if (!file.lens) return file.camera;
    return file_error(
        ErrorCode::format, name,
        "lens distortion (" + std::string(to_string(file.lens->model)) + ") is not a pinhole's; rectify the depth first");
  });
}

std::string camera_to_json(const Camera& camera) {
  return Json::object("width", camera.width, "height", camera.height, "fx", camera.fx, "fy", camera.fy, "cx", camera.cx, "cy",
                      camera.cy, "depth_scale", camera.depth_scale)
      .text();
}

std::optional<Camera> tum_camera(std::string_view name) {
  // The benchmark's file-format page, intrinsics of the colour cameras: the depth images are registered to them.
  constexpr std::array<Camera, 3> kCameras{{{640, 480, 517.3, 516.5, 318.6, 255.3, 5000.0},
                                            {640, 480, 520.9, 521.0, 325.1, 249.7, 5000.0},
                                            {640, 480, 535.4, 539.2, 320.1, 247.6, 5000.0}}};
  constexpr std::string_view kLong = "freiburg";
  constexpr std::string_view kShort = "fr";
  std::size_t number = name.find(kLong);
  if (number != std::string_view::npos) {
    number += kLong.size();
  } else if (name.starts_with(kShort)) {
    number = kShort.size();
  } else {
    return std::nullopt;
  }
  const std::string_view digits = name.substr(number, name.find_first_not_of("0123456789", number) - number);
  if (digits.size() != 1 || digits[0] < '1' || digits[0] > '3') return std::nullopt;
  return kCameras[static_cast<std::size_t>(digits[0] - '1')];
}

std::optional<Camera> camera_preset(std::string_view name) {
  // The default of ROS's OpenNI driver, as the TUM benchmark's file-format page lists it.
  if (name == "kinect1") return Camera{640, 480, 525.0, 525.0, 319.5, 239.5, 1000.0};
  return tum_camera(name);
}

}  // namespace fransac::io
