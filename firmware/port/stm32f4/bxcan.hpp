// SPDX-License-Identifier: Apache-2.0
// The bus behind the bxCAN of an STM32F4 (RM0090 chapter 32). Pins, the peripheral's clock and the vector table are the
// board's; the interrupts CANx_RX0, CANx_RX1 and CANx_TX call the functions of their names.
#pragma once
#include "can_dbc/tables.hpp"
#include "port/can.hpp"
#include "port/stm32/can_controller.hpp"
#include "port/stm32/can_timing.hpp"
#include "port/stm32f4/bxcan_registers.hpp"

namespace voltlap::port::stm32f4 {

using stm32::CanCounts;
using stm32::CanError;

class BxCan final : public Can {
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

  std::size_t receive(Frame* frames, std::size_t capacity) override;
  /// Never waits. A step begins with receive(), and may send more than once, for more than one node. What is left of
  /// the step before is dropped first: a frame older than a step must not pass for a fresh one when the bus comes
  /// back. False when some frame was dropped, now or of the step before.
  bool send(const TxQueue& frames) override;

  void on_receive_interrupt();  ///< CANx_RX0 and CANx_RX1
  void on_transmit_interrupt();  ///< CANx_TX

  [[nodiscard]] const CanCounts& counts() const { return counts_; }
  [[nodiscard]] bool bus_is_off() const { return off_; }

 private:
  CanError set_filters(const Config& config, const can::MessageRow* rows, std::size_t count);
  void take_from_fifo(std::size_t fifo);
  void fill_mailboxes();
  void load(std::size_t box, const Frame& frame);
  bool drop_old();
  void leave_bus_off();

  BxCanRegisters& regs_;
  BxCanRegisters& filters_;
  stm32::Inbox inbox_{};
  stm32::Outbox outbox_{};
  CanCounts counts_{};
  bool ready_ = false;
  bool new_step_ = true;  ///< the first send since frames were taken
  bool off_ = false;
};

}  // namespace voltlap::port::stm32f4
