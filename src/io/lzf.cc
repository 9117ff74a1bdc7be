// SPDX-License-Identifier: Apache-2.0
#include "io/lzf.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace fransac::io {
namespace {

// A byte below 32 begins a run of that many and one plain bytes. Any other begins a reference to bytes that are there already:
// its upper three bits are the length less 2, where 7 says that a byte with what is to be added follows; its lower five and one
// more byte are the distance less 1.
constexpr std::size_t kLongestRun = 32;
constexpr std::size_t kLongestReference = 264;
constexpr std::size_t kFarthest = 8192;
constexpr std::size_t kShortestReference = 3;
constexpr unsigned kLengthBits = 5;  ///< By which the length is shifted.
constexpr std::size_t kLengthFollows = 7;

/// Where three bytes were last seen, by their hash; the place is checked, so that clashes cost nothing but size.
class Places {
 public:
  /// The last place of the three bytes at `at`, which becomes `at`.
  std::size_t exchange(const std::uint8_t* at, std::size_t place) {
    const std::uint32_t three = (std::uint32_t{at[0]} << 16) | (std::uint32_t{at[1]} << 8) | at[2];
    return std::exchange(places_[(three * kMix) >> (32 - kBits)], place + 1);
  }

 private:
  static constexpr unsigned kBits = 14;
  static constexpr std::uint32_t kMix = 2654435761U;           // Knuth's multiplicative hash
  std::array<std::size_t, std::size_t{1} << kBits> places_{};  ///< One more than the place; 0: not seen.
};

void append_plain(std::string& out, std::span<const std::uint8_t> plain) {
  while (!plain.empty()) {
    const std::size_t run = std::min(plain.size(), kLongestRun);
    out += static_cast<char>(run - 1);
    out.append(reinterpret_cast<const char*>(plain.data()), run);
    plain = plain.subspan(run);
  }
}

void append_reference(std::string& out, std::size_t length, std::size_t distance) {
  const std::size_t coded = length - 2;
  const std::size_t back = distance - 1;
  out += static_cast<char>((std::min(coded, kLengthFollows) << kLengthBits) | (back >> 8));
  if (coded >= kLengthFollows) out += static_cast<char>(coded - kLengthFollows);
  out += static_cast<char>(back & 0xff);
}

}  // namespace

bool expand_lzf(std::span<const std::uint8_t> compressed, std::span<std::uint8_t> plain) {
  std::size_t in = 0;
  std::size_t out = 0;
  while (in < compressed.size()) {
    const std::size_t control = compressed[in++];
    if (control < kLongestRun) {
      const std::size_t run = control + 1;
      if (run > compressed.size() - in || run > plain.size() - out) return false;
      std::memcpy(plain.data() + out, compressed.data() + in, run);
      in += run;
      out += run;
      continue;
    }
    std::size_t length = (control >> kLengthBits) + 2;
    if (length == kLengthFollows + 2) {
      if (in == compressed.size()) return false;
      length += compressed[in++];
    }
    if (in == compressed.size()) return false;
    const std::size_t distance = ((control & (kLongestRun - 1)) << 8 | compressed[in++]) + 1;
    if (distance > out || length > plain.size() - out) return false;
    for (std::size_t end = out + length; out < end; ++out) plain[out] = plain[out - distance];  // may overlap itself
  }
  return out == plain.size();
}

std::string compress_lzf(std::span<const std::uint8_t> plain) {
  std::string out;
  Places places;
  std::size_t begin = 0;  // of what is not written yet
  std::size_t at = 0;
  while (at + kShortestReference <= plain.size()) {
    const std::size_t seen = places.exchange(plain.data() + at, at);
    const std::size_t distance = seen == 0 ? 0 : at - (seen - 1);
    if (distance == 0 || distance > kFarthest ||
        !std::equal(&plain[at], &plain[at] + kShortestReference, &plain[at - distance])) {
      ++at;
      continue;
    }
    const std::size_t longest = std::min(plain.size() - at, kLongestReference);
    std::size_t length = kShortestReference;
    while (length < longest && plain[at + length] == plain[at + length - distance]) ++length;
    append_plain(out, plain.subspan(begin, at - begin));
    append_reference(out, length, distance);
    at += length;
    begin = at;
  }
  append_plain(out, plain.subspan(begin));
  return out;
}

}  // namespace fransac::io
