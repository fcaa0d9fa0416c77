// SPDX-License-Identifier: Apache-2.0
// The bus behind an FDCAN of the STM32G4 in classic mode (RM0440 chapter 44). Pins, the kernel clock and the vector
// table are the board's; the interrupt FDCANx_IT0 calls on_interrupt.
#pragma once
#include "can_dbc/tables.hpp"
#include "port/can.hpp"
#include "port/stm32/can_controller.hpp"
#include "port/stm32/can_timing.hpp"
#include "port/stm32g4/fdcan_registers.hpp"

namespace voltlap::port::stm32g4 {

using stm32::CanCounts;
using stm32::CanError;

class FdCan final : public Can {
 public:
  struct Config {
    std::uint32_t clock_hz = 0;  ///< fdcan_tq_ck: the kernel clock behind CKDIV
    std::uint32_t bit_rate = can::kBitRate;
    std::uint32_t sample_point_permille = stm32::kSamplePoint_permille;
  };

  FdCan(FdCanRegisters& registers, MessageRam& ram) : regs_(registers), ram_(ram) {}

  /// As BxCan::init. Rows are sorted by identifier; a run of identifiers that follow each other takes one filter.
  [[nodiscard]] CanError init(const Config& config, const can::MessageRow* rows, std::size_t count);

  std::size_t receive(Frame* frames, std::size_t capacity) override;
  /// As BxCan::send: never waits, and what is left of the step before is dropped.
  bool send(const TxQueue& frames) override;

  void on_interrupt();  ///< FDCANx_IT0

  [[nodiscard]] const CanCounts& counts() const { return counts_; }
  [[nodiscard]] bool bus_is_off() const { return off_; }

 private:
  [[nodiscard]] bool set_filters(const can::MessageRow* rows, std::size_t count, std::uint32_t& lists);
  void take_from_fifo(std::size_t fifo);
  void fill_buffers();
  bool drop_old();
  void leave_bus_off();

  FdCanRegisters& regs_;
  MessageRam& ram_;
  stm32::Inbox inbox_{};
  stm32::Outbox outbox_{};
  CanCounts counts_{};
  bool ready_ = false;
  bool new_step_ = true;  ///< the first send since frames were taken
  bool off_ = false;
};

}  // namespace voltlap::port::stm32g4
