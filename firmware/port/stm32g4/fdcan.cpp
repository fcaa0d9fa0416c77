// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/fdcan.hpp"

namespace voltlap::port::stm32g4 {
namespace {

using stm32::wait_clear;
using stm32::wait_set;

constexpr std::uint32_t kStandardMask = 0x7FFU, kExtendedMask = 0x1FFF'FFFFU;
constexpr std::uint32_t kInterrupts = ir::kRf0n | ir::kRf0l | ir::kRf1n | ir::kRf1l | ir::kTc | ir::kTcf;
constexpr std::uint32_t kSending = ir::kTc | ir::kTcf;
constexpr std::uint32_t kAllBuffers = (1U << stm32::kMailboxes) - 1U;

bool is_extended(std::uint32_t id) { return (id & Frame::kExtendedFlag) != 0; }

/// Rows from `at` on whose identifiers follow each other; `at` stands behind them then.
std::uint32_t last_of_run(const can::MessageRow* rows, std::size_t count, std::size_t& at) {
  std::uint32_t last = rows[at].id;
  for (++at; at < count && rows[at].id == last + 1U && is_extended(rows[at].id) == is_extended(last); ++at) ++last;
  return last;
}

}  // namespace

bool FdCan::set_filters(const can::MessageRow* rows, std::size_t count, std::uint32_t& lists) {
  std::size_t standard = 0, extended = 0;
  for (std::size_t at = 0; at < count;) {
    const std::uint32_t first = rows[at].id;
    const std::uint32_t last = last_of_run(rows, count, at);
    if (is_extended(first)) {
      if (extended == kExtendedFilters) return false;
      ram_.extended[extended].f0.write(filter::kExtendedFifo1 | (first & kExtendedMask));
      ram_.extended[extended].f1.write(filter::kExtendedRangeUnmasked | (last & kExtendedMask));
      ++extended;
    } else {
      if (standard == kStandardFilters) return false;
      ram_.standard[standard].write(filter::kRange | filter::kStandardFifo0 |
                                    (first & kStandardMask) << filter::kFirstShift | (last & kStandardMask));
      ++standard;
    }
  }
  lists = static_cast<std::uint32_t>(standard << rxgfc::kLssShift | extended << rxgfc::kLseShift);
  return true;
}

CanError FdCan::init(const Config& config, const can::MessageRow* rows, std::size_t count) {
  ready_ = false;
  const stm32::CanTiming timing =
      stm32::can_timing(config.clock_hz, config.bit_rate, stm32::kFdCanLimits, config.sample_point_permille);
  if (timing.prescaler == 0) return CanError::kBitTiming;
  regs_.cccr.replace(cccr::kCsr, cccr::kInit);  // 44.3.2: INIT crosses clock domains and is read back before CCE
  if (!wait_clear(regs_.cccr, cccr::kCsa) || !wait_set(regs_.cccr, cccr::kInit)) return CanError::kNoInit;
  regs_.cccr.set(cccr::kCce);
  if (!wait_set(regs_.cccr, cccr::kCce)) return CanError::kNoInit;
  // Classic frames only: FDOE and BRSE off; retransmission as ISO 11898-1 has it: DAR off.
  regs_.cccr.clear(cccr::kFdoe | cccr::kBrse | cccr::kDar | cccr::kTest);
  regs_.nbtp.write((timing.segment2 - 1U) | (timing.segment1 - 1U) << 8 | (timing.prescaler - 1U) << 16 |
                   (timing.jump - 1U) << 25);
  std::uint32_t lists = 0;
  if (!set_filters(rows, count, lists)) return CanError::kFilters;
  regs_.rxgfc.write(rxgfc::kRejectAll | lists);  // F0OM, F1OM off: a full FIFO loses the newest frame
  regs_.txbc.write(0);                           // the three buffers are a FIFO: in the order of the requests
  regs_.ir.write(~0U);
  regs_.txbtie.write(kAllBuffers);  // without it IR.TC stays silent, and TCF without the next
  regs_.txbcie.write(kAllBuffers);
  regs_.ils.write(0);  // all on line 0
  regs_.ie.write(kInterrupts);
  regs_.ile.write(1U);
  ready_ = true;
  regs_.cccr.clear(cccr::kInit);  // takes CCE with it
  return wait_clear(regs_.cccr, cccr::kInit) ? CanError::kNone : CanError::kNotOnBus;
}

void FdCan::take_from_fifo(std::size_t fifo) {
  FdCanRegisters::Fifo& queue = regs_.rx[fifo];
  for (std::size_t i = 0; i < stm32::kFifoDepth; ++i) {
    const std::uint32_t status = queue.status.read();
    if ((status & fifo::kFill) == 0) return;
    const std::uint32_t get = (status >> fifo::kGetShift & 3U) % stm32::kFifoDepth;
    const Element& in = ram_.rx[fifo][get];
    const std::uint32_t head = in.head0.read();
    const bool ext = (head & element::kXtd) != 0;
    Frame frame;
    frame.id = ext ? (head & kExtendedMask) | Frame::kExtendedFlag : head >> element::kStandardShift & kStandardMask;
    const std::uint32_t dlc = in.head1.read() >> element::kDlcShift & 0xFU;
    frame.dlc = static_cast<std::uint8_t>(dlc < Frame::kMaxBytes ? dlc : Frame::kMaxBytes);
    stm32::put_word(frame, 0, in.data[0].read());
    stm32::put_word(frame, 4, in.data[1].read());
    queue.acknowledge.write(get);
    if ((head & element::kRtr) != 0) continue;
    take(frame);
  }
}

void FdCan::fill() {
  for (std::size_t i = 0; i < stm32::kMailboxes; ++i) {
    const std::uint32_t status = regs_.txfqs.read();
    Frame frame;
    if ((status & txfqs::kFull) != 0 || !next(frame)) return;
    const std::uint32_t put = (status >> txfqs::kPutShift & 3U) % stm32::kMailboxes;
    Element& out = ram_.tx[put];
    out.head0.write(stm32::extended(frame) ? (frame.id & kExtendedMask) | element::kXtd
                                           : (frame.id & kStandardMask) << element::kStandardShift);
    out.head1.write(std::uint32_t{frame.dlc} << element::kDlcShift);
    out.data[0].write(stm32::word_of(frame, 0));
    out.data[1].write(stm32::word_of(frame, 4));
    regs_.txbar.write(1U << put);
    ++counts_.sent;
  }
}

void FdCan::on_interrupt() {
  const std::uint32_t flags = regs_.ir.read() & kInterrupts;
  regs_.ir.write(flags);  // before the FIFOs are read: a frame that comes meanwhile raises it anew
  if ((flags & ir::kRf0l) != 0) ++counts_.overruns;
  if ((flags & ir::kRf1l) != 0) ++counts_.overruns;
  take_from_fifo(0);
  take_from_fifo(1);
  // While send() has them off it fills the buffers itself, and only reception may come in between.
  if ((flags & regs_.ie.read() & kSending) != 0) fill();
}

void FdCan::let_sending_interrupt(bool on) {
  if (on) {
    regs_.ie.set(kSending);
  } else {
    regs_.ie.clear(kSending);
  }
}

std::uint32_t FdCan::abort_waiting() {
  std::uint32_t waiting = 0;
  const std::uint32_t pending = regs_.txbrp.read() & kAllBuffers;
  for (std::size_t i = 0; i < stm32::kMailboxes; ++i) waiting += pending >> i & 1U;
  if (pending != 0) regs_.txbcr.write(pending);
  return waiting;
}

/// 44.3.6: bus-off sets INIT; the recovery, 129 times 11 recessive bits, begins when software clears it.
void FdCan::leave_bus_off() {
  const bool off = (regs_.psr.read() & psr::kBo) != 0;
  if (off && !off_) ++counts_.bus_off;
  if (!off && off_) ++counts_.recovered;
  off_ = off;
  if (off && (regs_.cccr.read() & cccr::kInit) != 0) regs_.cccr.clear(cccr::kInit);
}

}  // namespace voltlap::port::stm32g4
