// SPDX-License-Identifier: Apache-2.0
// A stream of frames needs no memory once its workspace has grown: calls of operator new are counted. (One table, of the
// voxel grid, comes from std::calloc; it grows with the leaves that a camera can see, not from frame to frame.)
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <span>
#include <vector>

#include "fransac/filter/deproject.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#if FRANSAC_WITH_IO
#include "io/grey_png.h"
#endif
#include "support.hpp"

// Sanitizers have an operator new of their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FRANSAC_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define FRANSAC_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef FRANSAC_COUNTS_ALLOCATIONS
#define FRANSAC_COUNTS_ALLOCATIONS 1
#endif

namespace {

std::atomic<std::uint64_t> allocations{0};

#if FRANSAC_COUNTS_ALLOCATIONS
void* counted(std::size_t size, std::size_t alignment) noexcept {
  ++allocations;
  return std::aligned_alloc(alignment, (size + alignment) / alignment * alignment);  // never of no bytes
}

void* counted_or_throw(std::size_t size, std::size_t alignment) {
  void* const p = counted(size, alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

constexpr std::size_t kPlain = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
std::size_t number(std::align_val_t alignment) { return static_cast<std::size_t>(alignment); }
#endif

}  // namespace

#if FRANSAC_COUNTS_ALLOCATIONS
void* operator new(std::size_t size) { return counted_or_throw(size, kPlain); }
void* operator new[](std::size_t size) { return counted_or_throw(size, kPlain); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size, kPlain); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size, kPlain); }
void* operator new(std::size_t size, std::align_val_t a) { return counted_or_throw(size, number(a)); }
void* operator new[](std::size_t size, std::align_val_t a) { return counted_or_throw(size, number(a)); }
void* operator new(std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept { return counted(size, number(a)); }
void* operator new[](std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept { return counted(size, number(a)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t, const std::nothrow_t&) noexcept { std::free(p); }
#endif

namespace fransac {
namespace {

class Allocations : public ::testing::Test {
 protected:
  void SetUp() override {
    if (FRANSAC_COUNTS_ALLOCATIONS == 0) GTEST_SKIP() << "the sanitizer has an operator new of its own";
  }
};

/// How many calls of operator new a call of `function` makes.
template <class Function>
std::uint64_t allocations_of(const Function& function) {
  const std::uint64_t before = allocations;
  function();
  return allocations - before;
}

/// Frames of a slowly moving camera, of one size.
std::vector<synth::SynthFrame> stream() {
  std::vector<synth::SynthFrame> frames;
  for (int frame = 0; frame < 3; ++frame) {
    auto rendered = synth::render({.frame = 10 * frame, .camera = {200, 150, 164.0, 164.0, 99.5, 74.5, 5000.0}});
    EXPECT_TRUE(rendered);
    if (rendered) frames.push_back(*std::move(rendered));
  }
  return frames;
}

DepthView view_of(const synth::SynthFrame& frame) {
  return DepthView::from_uint16(frame.depth.data(), frame.camera.width, frame.camera.height, frame.camera.depth_scale);
}

TEST_F(Allocations, AreCounted) {
  std::vector<std::uint64_t> values;
  EXPECT_EQ(allocations_of([&] { values.reserve(100); }), 1U);
  EXPECT_EQ(allocations_of([&] { values.resize(100); }), 0U);
  EXPECT_EQ(allocations_of([] { AlignedVector<float> more(10); }), 1U);
}

constexpr Method kMethods[] = {Method::cells, Method::fransac, Method::voxel_ransac, Method::rransac, Method::ransac};

/// A frame that the workspace has seen before, in whatever way it is segmented: check(allocations, options).
template <class Input, class Check>
void for_every_way(std::span<const Method> methods, const std::vector<Input>& inputs, const Check& check) {
  for (const Method method : methods) {
    for (const int max_planes : {1, 0}) {
      for (const LabelsFrom labels_from : {LabelsFrom::pixels, LabelsFrom::leaves}) {
        SegmentOptions options;
        options.method = method;
        options.max_planes = max_planes;
        if (uses(method, UsedBy::ransac)) options.labels_from = labels_from;
        options.cells.residuals = method == Method::cells && max_planes == 0;
        Workspace workspace;
        Segmentation segmentation;
        const auto segment_it = [&](const Input& input) { return input.segmented(options, workspace, segmentation); };
        for (int warm_up = 0; warm_up < 2; ++warm_up) {
          for (const Input& input : inputs) {
            const Status done = segment_it(input);
            ASSERT_TRUE(done) << done.error().message;
          }
        }
        for (const Input& input : inputs) {
          SCOPED_TRACE(::testing::Message() << enum_name(method) << ", planes " << max_planes << ", labels from "
                                            << enum_name(labels_from));
          check(allocations_of([&] { EXPECT_TRUE(segment_it(input)); }), options);
        }
      }
    }
  }
}

struct DepthInput {
  DepthView depth;
  const Camera* camera;
  Status segmented(const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) const {
    return segment(depth, *camera, options, workspace, segmentation);
  }
};

struct CloudInput {
  PointCloud cloud;
  Status segmented(const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) const {
    return segment(cloud, options, workspace, segmentation);
  }
};

#if FRANSAC_WITH_IO
TEST_F(Allocations, OfDepthPngsLikeThoseBefore) {
  std::vector<std::vector<std::byte>> files;
  for (const synth::SynthFrame& frame : stream()) {
    files.push_back(*io::encode_png(io::DepthImage{frame.camera.width, frame.camera.height, 1, frame.depth}));
  }
  io::GreyPngDecoder decoder;
  io::DepthImage image;
  const auto decode_all = [&] {
    for (const auto& file : files) EXPECT_TRUE(decoder.decode(file, {}, image));
  };
  decode_all();
  EXPECT_EQ(allocations_of(decode_all), 0U);
}
#endif

TEST_F(Allocations, OfDepthFramesSeenBefore) {
  const std::vector<synth::SynthFrame> frames = stream();
  std::vector<DepthInput> units;
  std::vector<DepthInput> metres;
  for (const synth::SynthFrame& frame : frames) {
    units.push_back({view_of(frame), &frame.camera});
    metres.push_back({DepthView::from_float(frame.exact_depth_m.data(), frame.camera.width, frame.camera.height), &frame.camera});
  }
  const auto check = [](std::uint64_t made, const SegmentOptions& /*options*/) { EXPECT_EQ(made, 0U); };
  for_every_way(kMethods, units, check);
  for_every_way(kMethods, metres, check);
}

TEST_F(Allocations, OfNewFramesOfTheSameSize) {
  // A few buffers may grow with the number of leaves or regions; no more than that, and nothing by the pixel or by the
  // hypothesis.
  const std::vector<synth::SynthFrame> frames = stream();
  for (const Method method : kMethods) {
    SegmentOptions options;
    options.method = method;
    Workspace workspace;
    Segmentation segmentation;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto segment_it = [&] {
        EXPECT_TRUE(segment(view_of(frames[i]), frames[i].camera, options, workspace, segmentation));
      };
      const std::uint64_t made = allocations_of(segment_it);
      if (i == 0) {
        segment_it();
      } else {
        EXPECT_LE(made, 12U) << enum_name(method) << ", frame " << i;
      }
    }
  }
}

TEST_F(Allocations, OfCloudsSeenBefore) {
  std::vector<CloudInput> inputs;
  for (const synth::SynthFrame& frame : stream()) deproject(view_of(frame), frame.camera, inputs.emplace_back().cloud);
  for_every_way(testing::kMethods, inputs, [&](std::uint64_t made, const SegmentOptions& /*options*/) { EXPECT_EQ(made, 0U); });
}

TEST_F(Allocations, OfOrganisedCloudsSeenBefore) {
  std::vector<CloudInput> inputs;
  for (const synth::SynthFrame& frame : stream()) {
    const DepthView depth = view_of(frame);
    PointCloud& cloud = inputs.emplace_back().cloud;
    cloud.width = depth.width();
    cloud.height = depth.height();
    cloud.resize(depth.size());
    std::size_t i = 0;
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) cloud.set(i++, depth.metres(u, v) * testing::ray(frame.camera, u, v).cast<float>());
    }
  }
  const Method cells[] = {Method::cells};
  for_every_way(cells, inputs, [&](std::uint64_t made, const SegmentOptions& /*options*/) { EXPECT_EQ(made, 0U); });
}

}  // namespace
}  // namespace fransac
