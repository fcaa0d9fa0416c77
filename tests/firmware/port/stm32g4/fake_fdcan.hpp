// SPDX-License-Identifier: Apache-2.0
// One FDCAN of the STM32G4 in classic mode as RM0440 chapter 44 describes it: INIT and CCE with their protection,
// filters in the message RAM, two FIFOs of three with get index and acknowledge, transmit FIFO or queue, interrupts
// cleared by ones, bus-off that sets INIT.
#pragma once
#include <optional>

#include "base/can_frame.hpp"
#include "firmware/port/stm32/fake_registers.hpp"
#include "port/stm32g4/fdcan_registers.hpp"

namespace voltlap::port::stm32g4::test {

class FakeFdCan final : public stm32::test::Model {
 public:
  FdCanRegisters block{};
  MessageRam ram{};  ///< plain memory

  bool clocked = true;
  bool bus_recessive = true;  ///< false: INIT never falls

  std::uint32_t read(std::size_t offset) override;
  void write(std::size_t offset, std::uint32_t value) override;

  std::optional<Frame> transmit_one();
  bool arrive(const Frame& frame, bool remote = false);
  void go_bus_off();
  void recessive_bits();
  [[nodiscard]] bool interrupt() const { return (ir_ & ie_) != 0 && (ile_ & 1U) != 0; }
  [[nodiscard]] std::uint32_t bit_timing() const { return nbtp_; }
  [[nodiscard]] bool in_init() const { return (cccr_ & cccr::kInit) != 0; }

 private:
  struct Fifo {
    std::uint32_t get = 0, fill = 0;
    bool lost = false;
  };
  [[nodiscard]] bool configurable() const { return (cccr_ & cccr::kInit) != 0 && (cccr_ & cccr::kCce) != 0; }
  [[nodiscard]] int fifo_for(const Frame& frame, bool remote) const;
  void write_cccr(std::uint32_t value);
  void cancel(std::uint32_t buffers);

  std::uint32_t cccr_ = cccr::kInit, nbtp_ = 0x0600'0A03U, rxgfc_ = 0, txbc_ = 0;
  std::uint32_t ir_ = 0, ie_ = 0, ile_ = 0, txbtie_ = 0, txbcie_ = 0;
  Fifo fifo_[2];
  std::uint32_t pending_ = 0, put_ = 0, get_ = 0;
  bool bus_off_ = false;
};

}  // namespace voltlap::port::stm32g4::test
