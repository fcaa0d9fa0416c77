// SPDX-License-Identifier: Apache-2.0
#include "fuzz/memory_meter.hpp"

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace {

// Readers have one thread.
std::ptrdiff_t now_bytes = 0, most_bytes = 0;

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  now_bytes += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  most_bytes = std::max(most_bytes, now_bytes);
  return memory;
}

void give_back(void* memory) noexcept {
  if (memory != nullptr) now_bytes -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return counted(std::malloc(std::max<std::size_t>(size, 1))); }
void* operator new(std::size_t size, std::align_val_t align) {
  const auto step = static_cast<std::size_t>(align);
  return counted(std::aligned_alloc(step, (std::max<std::size_t>(size, 1) + step - 1) / step * step));
}
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }

namespace voltlap::plant {

MemoryMeter::MemoryMeter() { now_bytes = most_bytes = 0; }

std::size_t MemoryMeter::most() const { return static_cast<std::size_t>(most_bytes); }

}  // namespace voltlap::plant
