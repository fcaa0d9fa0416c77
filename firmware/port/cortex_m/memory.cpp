// SPDX-License-Identifier: Apache-2.0
// The four functions that a compiler calls without being asked (GCC manual, "Standards"): an image has no C library.
// Built with -fno-tree-loop-distribute-patterns, which would make each a call of itself.
#include <cstddef>
#include <cstdint>

namespace {

bool aligned(const void* at) { return (reinterpret_cast<std::uintptr_t>(at) & 3U) == 0; }

/// Words where both ends allow it: states and queues of frames are copied so.
std::size_t copy_words(std::uint8_t* to, const std::uint8_t* from, std::size_t count) {
  if (!aligned(to) || !aligned(from)) return 0;
  std::size_t done = 0;
  for (; done + 4 <= count; done += 4) {
    *reinterpret_cast<std::uint32_t*>(to + done) = *reinterpret_cast<const std::uint32_t*>(from + done);
  }
  return done;
}

}  // namespace

extern "C" {

void* memcpy(void* to, const void* from, std::size_t count) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  for (std::size_t i = copy_words(out, in, count); i < count; ++i) out[i] = in[i];
  return to;
}

void* memmove(void* to, const void* from, std::size_t count) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  if (out <= in) {
    for (std::size_t i = 0; i < count; ++i) out[i] = in[i];
  } else {
    for (std::size_t i = count; i > 0; --i) out[i - 1] = in[i - 1];
  }
  return to;
}

void* memset(void* to, int value, std::size_t count) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto byte = static_cast<std::uint8_t>(value);
  std::size_t i = 0;
  if (aligned(out)) {
    for (; i + 4 <= count; i += 4) *reinterpret_cast<std::uint32_t*>(out + i) = 0x0101'0101U * byte;
  }
  for (; i < count; ++i) out[i] = byte;
  return to;
}

int memcmp(const void* left, const void* right, std::size_t count) {
  const auto* a = static_cast<const std::uint8_t*>(left);
  const auto* b = static_cast<const std::uint8_t*>(right);
  for (std::size_t i = 0; i < count; ++i) {
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

}  // extern "C"
