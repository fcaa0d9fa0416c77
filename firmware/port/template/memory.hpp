// SPDX-License-Identifier: Apache-2.0
// The memory that outlives the board's supply.
#pragma once
#include "port/nvm.hpp"

namespace voltlap::port {

class BoardMemory final : public Nvm {
 public:
  bool prepare() override;
  void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) override;
  NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) override;
  NvmResult step() override;
};

}  // namespace voltlap::port
