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
  auto* out = reinterpret_cast<std::uint32_t*>(to);
  const auto* in = reinterpret_cast<const std::uint32_t*>(from);
  const std::size_t words = count / 4;
  std::size_t i = 0;
  for (; i + 4 <= words; i += 4) {
    const std::uint32_t a = in[i], b = in[i + 1], c = in[i + 2], d = in[i + 3];
    out[i] = a;
    out[i + 1] = b;
    out[i + 2] = c;
    out[i + 3] = d;
  }
  for (; i < words; ++i) out[i] = in[i];
  return 4 * words;
}

std::size_t set_words(std::uint8_t* to, std::uint32_t value, std::size_t count) {
  auto* out = reinterpret_cast<std::uint32_t*>(to);
  const std::size_t words = count / 4;
  std::size_t i = 0;
  for (; i + 4 <= words; i += 4) out[i] = out[i + 1] = out[i + 2] = out[i + 3] = value;
  for (; i < words; ++i) out[i] = value;
  return 4 * words;
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
  for (std::size_t i = aligned(out) ? set_words(out, 0x0101'0101U * byte, count) : 0; i < count; ++i) out[i] = byte;
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
