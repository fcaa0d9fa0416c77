// SPDX-License-Identifier: Apache-2.0
// The bxCAN as RM0090 chapter 32 describes it: hand-shakes, write-1-to-clear and read-only bits, three mailboxes with
// both orders, filter banks, two FIFOs of three, bus-off. Nothing here is taken from the driver but the layout of the
// block.
#pragma once
#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "base/can_frame.hpp"
#include "firmware/port/stm32/fake_registers.hpp"
#include "port/stm32f4/bxcan_registers.hpp"

namespace voltlap::port::stm32f4::test {

class FakeBxCan final : public stm32::test::Model {
 public:
  BxCanRegisters block{};

  bool clocked = true;          ///< without its clock every register reads 0
  bool bus_recessive = true;    ///< false: shorted, so it never leaves initialisation
  bool release_sticks = false;  ///< RFOM never falls

  std::uint32_t read(std::size_t offset) override;
  void write(std::size_t offset, std::uint32_t value) override;

  /// Sends what is next by the manual's order; none while it is in initialisation, off, or has nothing.
  std::optional<Frame> transmit_one();
  /// A frame on the bus: true when a filter took it (also when the FIFO was full). `remote`: a remote frame.
  bool arrive(const Frame& frame, bool remote = false);
  /// 256 errors of transmission: off the bus (32.7.6).
  void go_bus_off() { bus_off_ = true; recovering_ = false; }
  /// 128 times 11 recessive bits have passed.
  void recessive_bits();
  [[nodiscard]] bool transmit_interrupt() const;
  [[nodiscard]] bool receive_interrupt() const;
  [[nodiscard]] std::uint32_t bit_timing() const { return btr_; }
  [[nodiscard]] bool in_init() const { return inak_; }

 private:
  struct Mailbox {
    std::uint32_t words[4] = {};
    bool pending = false, rqcp = false, txok = false;
    unsigned order = 0;
  };
  struct Fifo {
    std::deque<std::array<std::uint32_t, 4>> frames;
    bool full = false, overrun = false;
  };
  [[nodiscard]] std::uint32_t tsr() const;
  [[nodiscard]] bool filter_takes(const Frame& frame, bool remote, std::size_t& fifo) const;
  void write_mcr(std::uint32_t value);
  void write_tsr(std::uint32_t value);
  void write_fifo(std::size_t fifo, std::uint32_t value);
  void write_mailbox(std::size_t offset, std::uint32_t value);
  void write_filter(std::size_t offset, std::uint32_t value);

  std::uint32_t mcr_ = 0x0001'0002U;  // reset: sleep mode, DBF
  bool inak_ = false, slak_ = true;
  std::uint32_t ier_ = 0, btr_ = 0x0123'0000U;
  Mailbox tx_[3];
  Fifo fifo_[2];
  unsigned requests_ = 0;
  std::uint32_t fmr_ = 0x2A1C'0E01U, fm1r_ = 0, fs1r_ = 0, ffa1r_ = 0, fa1r_ = 0;
  std::uint32_t bank_[kFilterBanks][2] = {};
  bool bus_off_ = false, recovering_ = false;
};

}  // namespace voltlap::port::stm32f4::test
