// SPDX-License-Identifier: Apache-2.0
/// Everybody who can take part, whether their library was found or not.
#pragma once

#include <string_view>

namespace fransac::bench {

enum class Task {
  segment,     ///< Depth in memory to labels of all pixels in memory.
  voxel_grid,  ///< Cloud in memory to downsampled cloud in memory.
  sac,         ///< Cloud in memory to a plane and the indices of its inliers in memory.
  objects,     ///< Depth in memory to object ids of all pixels in memory.
  floor,       ///< What the machine allows.
};

struct Entry {
  std::string_view id;
  std::string_view library;
  std::string_view build;   ///< "packaged": as Debian ships it; "native": its headers, compiled for this machine.
  std::string_view method;  ///< Rivals of the same method are compared.
  Task task;
};

inline constexpr std::string_view kAllPlanes = "multi-plane";  ///< The method of those that return every plane.

inline constexpr Entry kRoster[] = {
    {"cells", "fransac", "project", kAllPlanes, Task::segment},
    {"fransac", "fransac", "project", "fransac", Task::segment},
    {"pcl-fransac-native", "pcl", "native", "fransac", Task::segment},
    {"pcl-fransac-packaged", "pcl", "packaged", "fransac", Task::segment},
    {"voxel-ransac", "fransac", "project", "voxel-ransac", Task::segment},
    {"pcl-voxel-ransac-native", "pcl", "native", "voxel-ransac", Task::segment},
    {"pcl-voxel-ransac-packaged", "pcl", "packaged", "voxel-ransac", Task::segment},
    {"open3d-segment-voxel", "open3d", "packaged", "voxel-ransac", Task::segment},
    {"rransac", "fransac", "project", "rransac", Task::segment},
    {"pcl-rransac-native", "pcl", "native", "rransac", Task::segment},
    {"pcl-rransac-packaged", "pcl", "packaged", "rransac", Task::segment},
    {"ransac", "fransac", "project", "ransac", Task::segment},
    {"pcl-ransac-native", "pcl", "native", "ransac", Task::segment},
    {"pcl-ransac-packaged", "pcl", "packaged", "ransac", Task::segment},
    {"open3d-segment", "open3d", "packaged", "ransac", Task::segment},
    {"pcl-organized-native", "pcl", "native", kAllPlanes, Task::segment},
    {"pcl-organized-packaged", "pcl", "packaged", kAllPlanes, Task::segment},
    {"opencv-rgbdplane", "opencv", "packaged", kAllPlanes, Task::segment},
    {"opencv-rgbdplane-normals", "opencv", "packaged", kAllPlanes, Task::segment},
    {"cgal-efficient-ransac", "cgal", "native", kAllPlanes, Task::segment},
    {"voxel-grid", "fransac", "project", "voxel-grid", Task::voxel_grid},
    {"voxel-grid-depth", "fransac", "project", "voxel-grid", Task::voxel_grid},
    {"pcl-voxelgrid-native", "pcl", "native", "voxel-grid", Task::voxel_grid},
    {"pcl-voxelgrid-packaged", "pcl", "packaged", "voxel-grid", Task::voxel_grid},
    {"pcl-approximate-voxelgrid-native", "pcl", "native", "voxel-grid", Task::voxel_grid},
    {"pcl-approximate-voxelgrid-packaged", "pcl", "packaged", "voxel-grid", Task::voxel_grid},
    {"adapter-voxelgrid", "fransac", "project", "voxel-grid", Task::voxel_grid},
    {"open3d-voxelgrid", "open3d", "packaged", "voxel-grid", Task::voxel_grid},
    {"adapter-sac", "fransac", "project", "sac", Task::sac},
    {"pcl-sac-native", "pcl", "native", "sac", Task::sac},
    {"pcl-sac-packaged", "pcl", "packaged", "sac", Task::sac},
    {"obstacles", "fransac", "project", "objects", Task::objects},
    {"pcl-clusters-native", "pcl", "native", "objects", Task::objects},
    {"pcl-clusters-packaged", "pcl", "packaged", "objects", Task::objects},
    {"pcl-voxel-clusters-native", "pcl", "native", "objects", Task::objects},
    {"pcl-voxel-clusters-packaged", "pcl", "packaged", "objects", Task::objects},
    {"floor-copy", "floor", "native", "floor", Task::floor},
    {"floor-deproject", "floor", "native", "floor", Task::floor},
    {"floor-label", "floor", "native", "floor", Task::floor},
};

}  // namespace fransac::bench
