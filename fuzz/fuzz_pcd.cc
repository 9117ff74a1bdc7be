// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: a cloud whose extent fits its points, or an error.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "io/cloud_formats.h"

namespace {

/// A copy of the input that ends where memory ends: the sanitizer does not see into PCL's library, the page fault does.
class AtTheEdge {
 public:
  explicit AtTheEdge(std::span<const std::uint8_t> data) : page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))) {
    const std::size_t room = (data.size() + page_ - 1) / page_ * page_;
    size_ = room + page_;
    memory_ = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) std::abort();
    auto* edge = static_cast<std::byte*>(memory_) + room;
    if (::mprotect(edge, page_, PROT_NONE) != 0) std::abort();
    bytes_ = {edge - data.size(), data.size()};
    if (!data.empty()) std::memcpy(edge - data.size(), data.data(), data.size());
  }
  AtTheEdge(const AtTheEdge&) = delete;
  AtTheEdge& operator=(const AtTheEdge&) = delete;
  ~AtTheEdge() { ::munmap(memory_, size_); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::size_t page_;
  std::size_t size_ = 0;
  void* memory_ = nullptr;
  std::span<const std::byte> bytes_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const AtTheEdge input({data, size});
  const auto cloud = fransac::io::cloud_formats::decode_pcd(input.bytes(), "fuzz");
  if (!cloud) return 0;
  const auto points = static_cast<std::size_t>(cloud->width) * static_cast<std::size_t>(cloud->height);
  if (points != cloud->size()) std::abort();
  return 0;
}
