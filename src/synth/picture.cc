// SPDX-License-Identifier: Apache-2.0
#include "synth/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fransac/core/random.hpp"

namespace fransac::synth::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Coordinates on a primitive's face in metres, from its middle, and the face's half sizes.
struct FacePoint {
  Vector2d at{0.0, 0.0};
  Vector2d half{0.0, 0.0};
};

FacePoint on_face(const Primitive& primitive, int face, const Vector3d& point) {
  const Vector3d p = primitive.pose.inverse() * point;
  const Vector3d& h = primitive.half;
  if (primitive.shape != Shape::box || face / 2 == 2) return {p.head<2>(), h.head<2>()};
  const int across = face / 2 == 0 ? 1 : 0;
  return {{p[across], p.z()}, {h[across], h.z()}};
}

std::uint32_t cell(double coordinate, double period) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(coordinate / period)));
}

Vector3d pattern_colour(const Primitive& primitive, int face, const Vector3d& point) {
  const Material& m = primitive.material;
  if (m.pattern == Pattern::plain) return m.colour;
  const FacePoint local = on_face(primitive, face, point);
  const Vector2d at = local.at + primitive.pattern_origin;
  const double period = m.period_m;
  switch (m.pattern) {
    case Pattern::checker: return (cell(at.x(), period) + cell(at.y(), period)) % 2 == 0 ? m.colour : m.second;
    case Pattern::planks: {
      constexpr double kJoint = 0.02;  // of a board's width
      constexpr double kLength = 9.0;  // in board widths
      const std::uint32_t board = cell(at.x(), period);
      const double shift = philox4x32({board, 0, 0, 0}, {0, 0})[0] * 0x1p-32;
      const double x = at.x() / period - std::floor(at.x() / period);
      const double along = at.y() / (kLength * period) + shift;
      const double y = along - std::floor(along);
      if (x < kJoint || y < kJoint / kLength) return m.second;
      const double tint = philox4x32({board, cell(along, 1.0), 1, 0}, {0, 0})[0] * 0x1p-32;
      return m.colour * (0.85 + 0.25 * tint);
    }
    case Pattern::framed: {
      const bool front = primitive.shape != Shape::box || face == 2 || face == 5;  // -y and the top
      const bool inside = ((local.half - local.at.cwiseAbs()).array() > period).all();
      return front && inside ? m.second : m.colour;
    }
    case Pattern::speckled: {
      const double mix = philox4x32({cell(at.x(), period), cell(at.y(), period), 2, 0}, {0, 0})[0] * 0x1p-32;
      return m.colour + mix * (m.second - m.colour);
    }
    case Pattern::plain: break;
  }
  return m.colour;
}

// Four points of a rotated grid within a pixel.
constexpr std::array<std::array<double, 2>, 4> kSamples{{{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};

class Painter {
 public:
  Painter(const Scene& scene, const Camera& camera)
      : scene_(scene), camera_(camera), eye_(scene, Vector3d::Zero()), lamp_(scene, scene.lamp) {}

  // A pixel that sees parts of several faces, or nothing.
  [[nodiscard]] Vector3d edge(int u, int v) const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [du, dv] : kSamples) {
      const Vector3d ray = pixel_ray(camera_, u + du, v + dv);
      const Hit hit = eye_.cast(ray);
      sum += hit.primitive < 0 ? sky(ray) : Vector3d(colour(hit, ray) * illumination(hit, hit.t * ray));
    }
    return sum / kSamples.size();
  }

  // A pixel within one face.
  [[nodiscard]] Vector3d interior(int u, int v, const Hit& hit) const {
    const Vector3d ray = pixel_ray(camera_, u, v);
    const Primitive& primitive = scene_.primitives[index(hit.primitive)];
    const int plane = scene_.plane_of_face[index(primitive.first_face + hit.face)];
    const double light = illumination(hit, hit.t * ray);
    if (plane < 0 || primitive.material.pattern == Pattern::plain) return light * colour(hit, ray);
    Vector3d sum = Vector3d::Zero();
    for (const auto& [du, dv] : kSamples) {
      const Vector3d sample = pixel_ray(camera_, u + du, v + dv);
      const double t = -scene_.planes[index(plane)].d / scene_.planes[index(plane)].normal.dot(sample);
      sum += colour({t, hit.primitive, hit.face}, sample);
    }
    return light / kSamples.size() * sum;
  }

 private:
  [[nodiscard]] Vector3d colour(const Hit& hit, const Vector3d& ray) const {
    return pattern_colour(scene_.primitives[index(hit.primitive)], hit.face, hit.t * ray);
  }

  [[nodiscard]] double illumination(const Hit& hit, const Vector3d& point) const {
    Vector3d normal = surface_normal(scene_.primitives[index(hit.primitive)], hit.face, point);
    if (normal.dot(point) > 0.0) normal = -normal;
    const Vector3d to_lamp = scene_.lamp - point;
    const double distance = to_lamp.norm();
    // A little light from the camera's left tells walls of equal paint apart.
    const double ambient = 0.40 + 0.12 * normal.dot(scene_.up) - 0.06 * normal.x();
    double direct = std::max(0.0, normal.dot(to_lamp)) / distance;
    if (direct > 0.0 && lamp_.blocked(point)) direct = 0.0;
    if (!scene_.outdoors) direct /= 1.0 + distance * distance / 12.0;  // a broad lamp: less steep than 1 / r^2
    return ambient + 1.1 * direct;
  }

  [[nodiscard]] Vector3d sky(const Vector3d& ray) const {
    if (!scene_.outdoors) return Vector3d::Zero();
    const double height = std::clamp(2.0 * ray.normalized().dot(scene_.up), 0.0, 1.0);
    return (1.0 - height) * Vector3d(0.75, 0.82, 0.88) + height * Vector3d(0.25, 0.45, 0.75);
  }

  const Scene& scene_;
  const Camera& camera_;
  RayCaster eye_;
  RayCaster lamp_;
};

std::uint8_t encode(double linear) {
  constexpr double kGamma = 2.2;  // of sRGB, nearly
  return static_cast<std::uint8_t>(std::lround(255.0 * std::pow(std::clamp(linear, 0.0, 1.0), 1.0 / kGamma)));
}

}  // namespace

std::vector<std::uint8_t> paint(const Scene& scene, const Camera& camera, const Raster& raster) {
  const Painter painter(scene, camera);
  const std::size_t width = index(camera.width);
  const auto is_edge = [&](int u, int v, std::size_t i) {
    const int face = raster.face[i];
    return face < 0 || (u > 0 && raster.face[i - 1] != face) || (u + 1 < camera.width && raster.face[i + 1] != face) ||
           (v > 0 && raster.face[i - width] != face) || (v + 1 < camera.height && raster.face[i + width] != face);
  };
  std::vector<std::uint8_t> picture;
  picture.reserve(3 * raster.face.size());
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      Vector3d light;
      if (is_edge(u, v, i)) {
        light = painter.edge(u, v);
      } else {
        const int first_face = scene.primitives[index(raster.primitive[i])].first_face;
        light = painter.interior(u, v, {raster.depth_m[i], raster.primitive[i], raster.face[i] - first_face});
      }
      for (const double channel : light) picture.push_back(encode(channel));
    }
  }
  return picture;
}

}  // namespace fransac::synth::detail
