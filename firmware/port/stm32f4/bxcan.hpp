// SPDX-License-Identifier: Apache-2.0
// The bus behind the bxCAN of an STM32F4 (RM0090 chapter 32). Pins, the peripheral's clock and the vector table are the
// board's; the interrupts CANx_RX0, CANx_RX1 and CANx_TX call the functions of their names.
#pragma once
#include "can_dbc/tables.hpp"
#include "port/stm32/can_controller.hpp"
#include "port/stm32/can_timing.hpp"
#include "port/stm32f4/bxcan_registers.hpp"

namespace voltlap::port::stm32f4 {

using stm32::CanError;

class BxCan final : public stm32::CanController {
 public:
  struct Config {
    std::uint32_t clock_hz = 0;  ///< of APB1
    std::uint32_t bit_rate = can::kBitRate;
    std::uint32_t sample_point_permille = stm32::kSamplePoint_permille;
    std::size_t bank_first = 0;  ///< filter banks of this controller: CAN1 from 0; those of CAN2 start at CAN2SB
    std::size_t banks = 0;
  };

  /// `filters` is the block of CAN1, which holds the filter banks of CAN2 as well.
  BxCan(BxCanRegisters& registers, BxCanRegisters& filters) : regs_(registers), filters_(filters) {}

  /// Bit timing, filters for exactly the identifiers of `rows` (sorted), and onto the bus. Waits at most 3
  /// hand-shakes (register.hpp). On kNotOnBus it is complete but for the bus itself; on any other error nothing is
  /// sent or received.
  [[nodiscard]] CanError init(const Config& config, const can::MessageRow* rows, std::size_t count);

  void on_receive_interrupt();  ///< CANx_RX0 and CANx_RX1
  void on_transmit_interrupt();  ///< CANx_TX

 private:
  CanError set_filters(const Config& config, const can::MessageRow* rows, std::size_t count);
  void take_from_fifo(std::size_t fifo);
  void load(std::size_t box, const Frame& frame);
  void let_sending_interrupt(bool on) override;
  void fill() override;
  std::uint32_t abort_waiting() override;
  void leave_bus_off() override;

  BxCanRegisters& regs_;
  BxCanRegisters& filters_;
};

}  // namespace voltlap::port::stm32f4
