// SPDX-License-Identifier: Apache-2.0
#include "fuzz/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "core/errors.hpp"
#include "fuzz/memory_meter.hpp"
#include "io/byte_source.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMegabyte = 1e6;
constexpr std::size_t kMemoryForByte = 50, kMemoryFloor = std::size_t{64} << 20;
constexpr std::size_t kZstdWindow = std::size_t{130} << 20;  // what a frame of zstd may ask for, however short it is
/// A few bytes of zstd unpack to gigabytes; what takes long because there is so much of it is no defect.
constexpr std::size_t kLongestUnpacked = std::size_t{4} << 20;

double processor_time_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool is_zstd(std::string_view input) { return input.starts_with("\x28\xB5\x2F\xFD"); }
bool is_packed(std::string_view input) { return is_zstd(input) || input.starts_with("\x1F\x8B"); }

/// Bytes of a packed file when it is unpacked, as far as it can be, up to just above kLongestUnpacked.
std::size_t unpacked_size(const std::string& path) {
  static std::array<char, 1 << 16> piece;
  ByteSource source(path, "an input");
  std::size_t size = 0;
  while (size <= kLongestUnpacked) {
    const std::size_t got = source.read(piece);
    if (got == 0) break;
    size += got;
  }
  return size;
}

void write(const std::string& path, std::string_view content) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  if (!file.flush()) throw std::runtime_error(path + " cannot be written");
}

}  // namespace

std::string Trial::run(const FuzzTarget& target, std::string_view input) {
  const std::string path = fmt::format("{}/{}", folder_.path(), target.file);
  write(path, input);
  const std::size_t size = is_packed(input) ? unpacked_size(path) : input.size();
  if (size > kLongestUnpacked) return {};
  const double begin_s = processor_time_s();
  MemoryMeter memory;
  std::string wrong;
  try {
    target.read(path);
  } catch (const InputError& error) {
    if (std::string_view(error.what()).empty()) wrong = "an InputError that says nothing";
  } catch (const std::exception& error) {
    wrong = fmt::format("no InputError but: {}", error.what());
  }
  const std::size_t most = memory.most();
  const double took_s = processor_time_s() - begin_s;
  if (!wrong.empty()) return wrong;
  const double allowed_s = target.slowest_s * std::max(1.0, static_cast<double>(size) / kMegabyte);
  if (took_s > allowed_s) {
    return fmt::format("took {:.1f} s for {} bytes, allowed are {:.1f} s", took_s, size, allowed_s);
  }
  const std::size_t allowed = std::max(kMemoryFloor + (is_zstd(input) ? kZstdWindow : 0), kMemoryForByte * size);
  if (most > allowed) return fmt::format("took {} bytes of memory for {} bytes, allowed are {}", most, size, allowed);
  return {};
}

}  // namespace voltlap::plant
