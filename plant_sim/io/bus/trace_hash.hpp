// SPDX-License-Identifier: Apache-2.0
// One number for all frames of a run, and one for each node's: two runs that agree in it agree in every frame.
//   SHA-256 over tick (u32), sender (u8), id (u32, bit 31: extended), dlc (u8), data (dlc bytes), little-endian,
//   in the order of sending.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/bus/frame_sink.hpp"

struct evp_md_ctx_st;

namespace voltlap::plant {

/// SHA-256 of a stream of bytes, fed in blocks.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(const std::uint8_t* bytes, std::size_t count);
  /// 64 hexadecimal digits. The hash is complete then; nothing may be added.
  [[nodiscard]] std::string finish();

 private:
  void flush();
  evp_md_ctx_st* context_;
  std::vector<std::uint8_t> pending_;
};

class TraceHash : public FrameSink {
 public:
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override;

  struct Result {
    std::string trace, plant, bms, master;
  };
  [[nodiscard]] Result finish();

 private:
  Sha256 trace_;
  std::array<Sha256, kSenders> node_;
};

}  // namespace voltlap::plant
