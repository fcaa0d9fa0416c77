// SPDX-License-Identifier: Apache-2.0
// Stands before malloc of the GNU C library.
#include "fuzz/memory_meter.hpp"

#include <malloc.h>

#include <algorithm>
#include <cstdlib>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t step, std::size_t size);
void __libc_free(void* memory);
}

namespace {

// Readers have one thread.
std::ptrdiff_t now_bytes = 0, most_bytes = 0;

void* taken(void* memory) {
  now_bytes += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  most_bytes = std::max(most_bytes, now_bytes);
  return memory;
}

void give_back(void* memory) { now_bytes -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory)); }

}  // namespace

extern "C" {
void* malloc(std::size_t size) { return taken(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return taken(__libc_calloc(count, size)); }
void* aligned_alloc(std::size_t step, std::size_t size) { return taken(__libc_memalign(step, size)); }
void* realloc(void* memory, std::size_t size) {
  give_back(memory);
  return taken(__libc_realloc(memory, size));
}
void free(void* memory) {
  give_back(memory);
  __libc_free(memory);
}
}

namespace voltlap::plant {

MemoryMeter::MemoryMeter() { now_bytes = most_bytes = 0; }

std::size_t MemoryMeter::most() const { return static_cast<std::size_t>(most_bytes); }

}  // namespace voltlap::plant
