// SPDX-License-Identifier: Apache-2.0
/// Finding frames: single files, folders of frames, TUM RGB-D sequences, clouds.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"
#include "fransac/core/true_object.hpp"
#include "fransac/io/image.hpp"

namespace fransac::io {

/// What an input is; found from its content, then from its name.
enum class InputKind {
  depth_image,   ///< A 16-bit PNG, or another file that read_depth_image() knows.
  frame,         ///< A folder with depth.png, .tiff, .tif, .pgm or .npy (and a camera): one frame.
  dataset,       ///< A folder whose sub-folders are frames, with or without dataset.json; or a folder of depth images (with a
                 ///< camera.json).
  tum_sequence,  ///< A folder with depth.txt, or with associations.txt.
  pcd,           ///< A cloud in PCL's format.
  ply,           ///< A cloud in the Stanford polygon format.
  xyz,           ///< A cloud as lines of text, told by the file's ending .xyz.
};
/// Whether it is a point cloud, which read_cloud() reads, and no depth frames.
bool is_cloud(InputKind kind);
/// The name of a kind as it stands in this header, for example "tum_sequence".
std::string_view to_string(InputKind kind);

/// Errors: io when it does not exist or cannot be read; format when it is none of the kinds (the message says what was looked
/// for).
Result<InputKind> detect_kind(const std::filesystem::path& input);

/// The truth that a dataset's labels hold.
enum class Truth {
  none,      ///< There are no labels.
  dominant,  ///< Only label 1, the dominant plane, is annotated.
  planes,    ///< All planes are annotated.
};

/// Where a frame's files are; nothing is loaded yet.
struct FrameFiles {
  std::string name;                                  ///< Scene name: the frame folder's name, or the timestamp of a sequence.
  std::filesystem::path depth;                       ///< As read_depth_image() reads it.
  std::optional<std::filesystem::path> colour;       ///< JPEG or PNG.
  std::optional<std::filesystem::path> labels;       ///< 8-bit PNG.
  std::optional<std::filesystem::path> objects;      ///< objects.png, 8 or 16 bit.
  std::optional<std::filesystem::path> regions;      ///< gt_seg.png, 8 bit: regions as Hoover et al. (1996) number them.
  std::optional<std::filesystem::path> truth;        ///< truth.json with plane coefficients.
  std::optional<std::filesystem::path> camera_file;  ///< As read_camera_file() knows it.
  std::optional<Camera> camera;                      ///< Known without a file; scaled to an image of the same aspect ratio.
  std::optional<double> timestamp_s;                 ///< Of a sequence.
  std::optional<int> floor;                          ///< The floor's label, where dataset.json tells it.
  std::optional<double> depth_scale;                 ///< Raw units per metre, instead of the camera's.
  ReadLimits limits{};                               ///< Of its images.
};

/// The frames of an input; nothing is loaded yet.
struct Dataset {
  std::string name;                     ///< The folder's name.
  InputKind kind = InputKind::dataset;  ///< What the input is.
  Truth truth = Truth::none;            ///< What its labels hold.
  std::string sensor;                   ///< dataset.json's "sensor", or empty.
  std::vector<FrameFiles> frames;       ///< Sorted by name; a sequence: by time.
  /// Files of the whole input, as far as they exist: dataset.json; of a sequence depth.txt, rgb.txt, associations.txt and
  /// groundtruth.txt.
  std::vector<std::filesystem::path> files;
};

/// Lists the frames of a depth image, a frame folder, a dataset or a TUM sequence (not of a cloud).
/// TUM: depth.txt lines "timestamp filename", '#' comments; rgb.txt associated by nearest timestamp within 20 ms; without
/// depth.txt associations.txt, lines "timestamp picture timestamp depth-image"; intrinsics from the camera's file beside it, else
/// from the folder's name (freiburg1..3). A depth image that is named depth.png, in a folder of its own, has what lies beside it:
/// its camera, colour and truth. What lies beside a single depth image is its own when it is named depth.png (or another such
/// name) or is the folder's only depth image, else only the camera's file is: camera.json, camera.yaml or camera.yml, of any kind
/// that read_camera_file() knows. `truth`, `sensor` and `floor` are from dataset.json in the folder, or above a single frame;
/// without one, labels are taken for all planes. A folder without a frame is a no_data error; a depth.txt line that cannot be
/// read is a format error naming file and line.
Result<Dataset> list_frames(const std::filesystem::path& input);

/// A loaded frame.
struct Frame {
  std::string name;                                ///< As FrameFiles::name.
  Camera camera;                                   ///< Of the depth image's size.
  DepthImage depth;                                ///< Raw units; without pixels where the file holds metres.
  std::optional<LabelImage> labels;                ///< True labels; 0 is not judged.
  std::optional<ObjectImage> objects;              ///< Ids of free-standing objects; 0: none, or not measured.
  std::optional<LabelImage> regions;               ///< True regions as Hoover et al. (1996) number them: from 10 on.
  std::vector<std::pair<int, Plane>> true_planes;  ///< (label, plane) from truth.json, canonical sign.
  std::optional<int> floor;                        ///< The floor's true label; 0: no floor is seen; nothing: nobody says.
  MetresImage metres{};                            ///< Depth of a file that holds metres; else without pixels.

  /// The depth image; valid while this is not changed.
  [[nodiscard]] DepthView view() const { return metres.pixels.empty() ? io::view(depth, camera.depth_scale) : io::view(metres); }
};

/// Loads depth, in raw units or in metres (then the camera's depth_scale means nothing; the files' depth_scale, if any, divides
/// the values), camera (`camera_file` overrides what the frame has; neither is an error that names both), labels, objects,
/// regions and truth. Camera and images must have the depth image's size. `floor` is what truth.json says, else what dataset.json
/// does.
Result<Frame> load_frame(const FrameFiles& files, const std::optional<std::filesystem::path>& camera_file = std::nullopt);

/// Memory that load_frame keeps from frame to frame. One thread at a time.
class LoadWorkspace {
 public:
  LoadWorkspace() noexcept;  ///< Takes no memory yet.
  LoadWorkspace(LoadWorkspace&&) noexcept;
  LoadWorkspace& operator=(LoadWorkspace&&) noexcept;
  ~LoadWorkspace();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;  ///< Null until the first frame.
  friend Status load_frame(const FrameFiles&, const std::optional<std::filesystem::path>&, LoadWorkspace&, Frame&);
};
/// The same into `frame`, whose depth image's memory is used again; after an error it is not to be used.
Status load_frame(const FrameFiles& files, const std::optional<std::filesystem::path>& camera_file, LoadWorkspace& workspace,
                  Frame& frame);

/// What labels mean the same in.
enum class LabelScope {
  frame,     ///< Numbered anew in each frame.
  sequence,  ///< A label is the same plane in all frames of the folder.
};

/// Writes one frame folder in the frames format: depth.png, camera.json, and, where given, labels.png, objects.png, rgb.png, and
/// truth.json: "labels_hold_for" "frame" or "sequence"; "pose" of the camera in the world, "translation" and "quaternion" (x, y,
/// z, w); "floor", its label, or null where none is seen; "planes"; "objects" with their id and box: centre, size, along, up,
/// yaw_rad, and the support plane and the height range above it (null where there is none).
struct FrameToWrite {
  Camera camera;                                    ///< camera.json.
  DepthImage depth;                                 ///< depth.png, raw units.
  std::optional<LabelImage> labels;                 ///< labels.png.
  std::optional<ObjectImage> objects;               ///< objects.png.
  std::optional<ColourImage> colour;                ///< rgb.png.
  LabelScope label_scope = LabelScope::frame;       ///< What the labels mean the same in.
  std::vector<std::pair<int, Plane>> true_planes;   ///< (label, plane) in the camera's frame.
  std::optional<int> floor;                         ///< The floor's label; 0: none is seen; nothing: truth.json does not say.
  std::vector<TrueObject> true_objects;             ///< In the camera's frame.
  std::optional<Eigen::Isometry3d> T_world_camera;  ///< p_world = T_world_camera * p_camera.
};
/// See FrameToWrite. Errors name the file, or the part whose size is not the depth image's.
Status write_frame(const std::filesystem::path& folder, const FrameToWrite& frame);
/// Writes dataset.json into a folder of frames.
Status write_dataset_json(const std::filesystem::path& folder, Truth truth, const std::string& sensor);

}  // namespace fransac::io
