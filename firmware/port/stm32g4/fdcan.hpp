// SPDX-License-Identifier: Apache-2.0
// The bus behind an FDCAN of the STM32G4 in classic mode (RM0440 chapter 44). Pins, the kernel clock and the vector
// table are the board's; the interrupt FDCANx_IT0 calls on_interrupt.
#pragma once
#include "can_dbc/tables.hpp"
#include "port/stm32/can_controller.hpp"
#include "port/stm32/can_timing.hpp"
#include "port/stm32g4/fdcan_registers.hpp"

namespace voltlap::port::stm32g4 {

using stm32::CanError;

class FdCan final : public stm32::CanController {
 public:
  struct Config {
    std::uint32_t clock_hz = 0;  ///< fdcan_tq_ck: the kernel clock behind CKDIV
    std::uint32_t bit_rate = can::kBitRate;
    std::uint32_t sample_point_permille = stm32::kSamplePoint_permille;
  };

  FdCan(FdCanRegisters& registers, MessageRam& ram) : regs_(registers), ram_(ram) {}

  /// As BxCan::init. Rows are sorted by identifier; a run of identifiers that follow each other takes one filter.
  [[nodiscard]] CanError init(const Config& config, const can::MessageRow* rows, std::size_t count);

  void on_interrupt();  ///< FDCANx_IT0

 private:
  [[nodiscard]] bool set_filters(const can::MessageRow* rows, std::size_t count, std::uint32_t& lists);
  void take_from_fifo(std::size_t fifo);
  void let_sending_interrupt(bool on) override;
  void fill() override;
  std::uint32_t abort_waiting() override;
  void leave_bus_off() override;

  FdCanRegisters& regs_;
  MessageRam& ram_;
};

}  // namespace voltlap::port::stm32g4
