// SPDX-License-Identifier: Apache-2.0
/// The solids that scenes are made of, and what a ray meets first.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "fransac/core/plane.hpp"

namespace fransac::synth::detail {

/// Solids in their own frame, centred on the origin, with half sizes h:
/// rectangle |x| <= hx, |y| <= hy, z = 0; box |x| <= hx, |y| <= hy, |z| <= hz; cylinder x^2 + y^2 <= hx^2, |z| <= hz;
/// sphere of radius hx.
enum class Shape { rectangle, box, cylinder, sphere };

inline constexpr double kMiss = std::numeric_limits<double>::infinity();

/// Where origin + t * direction enters (or, from inside, leaves) a solid; the direction need not be a unit vector.
/// Faces: rectangle 0; box 2 * axis, + 1 on the positive side; cylinder 0 round, 1 bottom, 2 top; sphere 0.
struct Hit {
  double t = kMiss;
  int primitive = -1;
  int face = 0;
};
Hit intersect(Shape shape, const Eigen::Vector3d& half, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

int face_count(Shape shape);
/// A planar face in the solid's frame, outward normal; nothing for a curved one.
struct FacePlane {
  Eigen::Vector3d normal;
  double distance = 0.0;  ///< Of the face from the solid's centre.
};
std::optional<FacePlane> face_plane(Shape shape, const Eigen::Vector3d& half, int face);

enum class Pattern {
  plain,
  checker,   ///< Squares of `period_m`.
  planks,    ///< Boards of width `period_m` with dark joints.
  framed,    ///< The second colour inside a margin of width `period_m`: a screen in its bezel, a book's cover, a door.
  speckled,  ///< Cells of `period_m` of random brightness: asphalt, carpet.
};

struct Material {
  Eigen::Vector3d colour{0.7, 0.7, 0.7};  ///< Albedo; red, green, blue; linear.
  Eigen::Vector3d second{0.3, 0.3, 0.3};  ///< The pattern's other colour.
  Pattern pattern = Pattern::plain;
  double period_m = 0.1;
  double texture = 0.85;  ///< What a stereo matcher finds to match, 0 to 1.
};

struct Primitive {
  Shape shape = Shape::box;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  Material material;
  Eigen::Vector2d pattern_origin{0.0, 0.0};  ///< Makes the pattern run on over the rectangles of one wall or floor.
  int first_face = 0;                        ///< Faces are numbered through the scene.
};

/// The outward unit normal of a primitive's face at a point on it.
Eigen::Vector3d surface_normal(const Primitive& primitive, int face, const Eigen::Vector3d& point);

/// Primitives [first, last) that belong together: coplanar faces among them are one physical surface.
struct Object {
  int first = 0;
  int last = 0;
  int id = 0;  ///< 1, 2, 3 … for what stands freely; 0 for the room and what things stand on.
};

struct Scene {
  std::vector<Primitive> primitives;
  std::vector<Object> objects;
  Eigen::Vector3d lamp{0.0, 0.0, 2.0};
  bool outdoors = false;
  Eigen::Vector3d up{0.0, 0.0, 1.0};
  std::vector<int> plane_of_face;  ///< Index into `planes`, -1 for curved faces.
  std::vector<Plane> planes;       ///< Coplanar faces of one object share an entry.

  /// Moves everything to another frame, p' = transform * p, then fills `plane_of_face` and `planes`.
  void move_to(const Eigen::Isometry3d& transform);
  /// Whether a solid (not a rectangle) encloses the point.
  [[nodiscard]] bool encloses(const Eigen::Vector3d& point) const;
};

/// Casts rays from one point into a scene that outlives it.
class RayCaster {
 public:
  RayCaster(const Scene& scene, const Eigen::Vector3d& origin);

  /// The nearest hit before t_max.
  [[nodiscard]] Hit cast(const Eigen::Vector3d& direction, double t_max = kMiss) const;
  /// Whether something stands between the origin and the point.
  [[nodiscard]] bool blocked(const Eigen::Vector3d& point) const;

 private:
  struct Ball {                      ///< A bounding sphere, seen from the origin.
    double x, y, z, radius, beyond;  // beyond = |centre|^2 - radius^2: negative from inside
    [[nodiscard]] bool missed(const Eigen::Vector3d& direction, double direction_squared, double t_max) const {
      if (beyond <= 0.0) return false;
      const double along = direction.x() * x + direction.y() * y + direction.z() * z;
      return along <= 0.0 || along * along < beyond * direction_squared ||
             along - radius * std::sqrt(direction_squared) > t_max * direction_squared;
    }
  };
  struct Local {
    Eigen::Matrix3d rotation;  ///< From the caster's frame to the solid's.
    Eigen::Vector3d origin;
    Ball ball;
  };
  static Ball ball_at(const Eigen::Vector3d& centre, double radius);

  const Scene& scene_;
  Eigen::Vector3d origin_;
  std::vector<Ball> balls_;    ///< One per object.
  std::vector<Local> locals_;  ///< One per primitive.
};

}  // namespace fransac::synth::detail
