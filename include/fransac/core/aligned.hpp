// SPDX-License-Identifier: Apache-2.0
/// Memory aligned for vector loads.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace fransac {

/// Alignment in bytes of every array that a kernel reads: one cache line, the widest vector register in use.
inline constexpr std::size_t kAlignment = 64;

/// A standard allocator whose blocks start on a `kAlignment` boundary.
template <class T>
struct AlignedAllocator {
  using value_type = T;  ///< Of the elements.
  AlignedAllocator() = default;
  /// Allocators of all types are alike.
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>& /*other*/) {}  // NOLINT(google-explicit-constructor)
  /// Memory for n elements; throws std::bad_alloc.
  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{kAlignment}));
  }
  /// Gives it back.
  void deallocate(T* p, std::size_t /*n*/) { ::operator delete (p, std::align_val_t{kAlignment}); }
  /// Growing a vector leaves new elements uninitialised: every user overwrites them.
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  /// Constructs from arguments, as every allocator does.
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  /// Each frees what another allocated.
  template <class U>
  bool operator==(const AlignedAllocator<U>& /*other*/) const {
    return true;
  }
};

/// A vector whose elements start on a `kAlignment` boundary; growing leaves new elements uninitialised.
template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace fransac
