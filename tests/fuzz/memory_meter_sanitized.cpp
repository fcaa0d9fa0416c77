// SPDX-License-Identifier: Apache-2.0
#include <sanitizer/allocator_interface.h>

#include <algorithm>

#include "fuzz/memory_meter.hpp"

namespace voltlap::plant {
namespace {

// Readers have one thread.
std::ptrdiff_t now_bytes = 0, most_bytes = 0;

void taken(const volatile void*, std::size_t size) {
  now_bytes += static_cast<std::ptrdiff_t>(size);
  most_bytes = std::max(most_bytes, now_bytes);
}

void given_back(const volatile void* memory) {
  if (memory == nullptr) return;
  now_bytes -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(const_cast<const void*>(memory)));
}

}  // namespace

MemoryMeter::MemoryMeter() {
  static const int installed = __sanitizer_install_malloc_and_free_hooks(taken, given_back);
  static_cast<void>(installed);
  now_bytes = most_bytes = 0;
}

std::size_t MemoryMeter::most() const { return static_cast<std::size_t>(most_bytes); }

}  // namespace voltlap::plant
