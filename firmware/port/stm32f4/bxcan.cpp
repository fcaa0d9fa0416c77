// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/bxcan.hpp"

namespace voltlap::port::stm32f4 {
namespace {

using stm32::wait_clear;
using stm32::wait_set;

constexpr std::uint32_t kStandardMask = 0x7FFU, kExtendedMask = 0x1FFF'FFFFU;
constexpr std::uint32_t kReleaseReads = 16;  // RFOM falls within a few clocks of APB1

constexpr std::uint32_t kShortRtr = 1U << 4, kShortIde = 1U << 3;
constexpr std::size_t kBlockMin = 4;  // identifiers of a block that a mask is worth: a list holds twice as many entries

/// 32.7.4: in 16 bits, STID stands in bits 15:5; RTR and IDE are 0.
std::uint32_t short_filter(std::uint32_t id) { return (id & kStandardMask) << 5; }
std::uint32_t long_filter(std::uint32_t id) {
  return (id & kExtendedMask) << mailbox::kExtendedShift | mailbox::kIde;
}
bool is_extended(std::uint32_t id) { return (id & Frame::kExtendedFlag) != 0; }

/// How many identifiers from `at` on follow each other and make a block that one mask names: a power of two.
std::size_t block_at(const can::MessageRow* rows, std::size_t count, std::size_t at) {
  std::size_t run = 1;
  while (at + run < count && rows[at + run].id == rows[at].id + run) ++run;
  std::size_t block = 1;
  while (2 * block <= run && (rows[at].id & (2 * block - 1)) == 0) block *= 2;
  return block;
}

/// Fills bank after bank; filters of one kind share one.
class Banks {
 public:
  Banks(BxCanRegisters& regs, std::size_t first, std::size_t end) : regs_(regs), next_(first), end_(end) {}

  bool add_short(std::uint32_t id) {
    ids_[ids_count_++] = short_filter(id);
    return ids_count_ < 4 || flush_short();
  }
  bool add_block(std::uint32_t id, std::size_t size) {
    const auto mask = static_cast<std::uint32_t>(~(size - 1));
    blocks_[blocks_count_++] = short_filter(id) | (short_filter(mask) | kShortRtr | kShortIde) << 16;
    return blocks_count_ < 2 || flush_blocks();
  }
  bool add_long(std::uint32_t id) {
    longs_[longs_count_++] = long_filter(id);
    return longs_count_ < 2 || flush_long();
  }
  /// What is not full repeats its last.
  bool finish() { return flush_short() && flush_blocks() && flush_long(); }
  [[nodiscard]] std::uint32_t used() const { return used_; }

 private:
  bool flush_short() {
    if (ids_count_ == 0) return true;
    for (std::size_t i = ids_count_; i < 4; ++i) ids_[i] = ids_[ids_count_ - 1];
    ids_count_ = 0;
    return write(true, false, 0, ids_[0] | ids_[1] << 16, ids_[2] | ids_[3] << 16);
  }
  bool flush_blocks() {
    if (blocks_count_ == 0) return true;
    const std::uint32_t second = blocks_[blocks_count_ - 1];
    blocks_count_ = 0;
    return write(false, false, 0, blocks_[0], second);
  }
  bool flush_long() {
    if (longs_count_ == 0) return true;
    const std::uint32_t second = longs_[longs_count_ - 1];
    longs_count_ = 0;
    return write(true, true, 1, longs_[0], second);  // FIFO 1: a long identifier waits for no short one
  }
  bool write(bool list, bool wide, std::uint32_t fifo, std::uint32_t r1, std::uint32_t r2) {
    if (next_ >= end_) return false;
    const std::uint32_t bit = 1U << next_;
    regs_.fm1r.replace(bit, list ? bit : 0);
    regs_.fs1r.replace(bit, wide ? bit : 0);
    regs_.ffa1r.replace(bit, fifo != 0 ? bit : 0);
    regs_.bank[next_].r1.write(r1);
    regs_.bank[next_].r2.write(r2);
    used_ |= bit;
    ++next_;
    return true;
  }

  BxCanRegisters& regs_;
  std::size_t next_, end_;
  std::uint32_t used_ = 0;
  std::uint32_t ids_[4] = {}, blocks_[2] = {}, longs_[2] = {};
  std::size_t ids_count_ = 0, blocks_count_ = 0, longs_count_ = 0;
};

bool add_rows(Banks& banks, const can::MessageRow* rows, std::size_t count) {
  for (std::size_t at = 0; at < count;) {
    const std::uint32_t id = rows[at].id;
    const std::size_t block = is_extended(id) ? 1 : block_at(rows, count, at);
    const bool masked = block >= kBlockMin;
    const bool room = is_extended(id) ? banks.add_long(id)
                      : masked        ? banks.add_block(id, block)
                                      : banks.add_short(id);
    if (!room) return false;
    at += masked ? block : 1;
  }
  return banks.finish();
}

}  // namespace

CanError BxCan::set_filters(const Config& config, const can::MessageRow* rows, std::size_t count) {
  const std::size_t end = config.bank_first + config.banks;
  if (end > kFilterBanks) return CanError::kFilters;
  std::uint32_t own = 0;
  for (std::size_t i = config.bank_first; i < end; ++i) own |= 1U << i;
  filters_.fmr.set(fmr::kFinit);  // filters may be written now; reception of both controllers rests
  filters_.fa1r.clear(own);
  Banks banks(filters_, config.bank_first, end);
  const bool fit = add_rows(banks, rows, count);
  if (fit) filters_.fa1r.set(banks.used());
  filters_.fmr.clear(fmr::kFinit);
  return fit ? CanError::kNone : CanError::kFilters;
}

CanError BxCan::init(const Config& config, const can::MessageRow* rows, std::size_t count) {
  ready_ = false;
  const stm32::CanTiming timing =
      stm32::can_timing(config.clock_hz, config.bit_rate, stm32::kBxCanLimits, config.sample_point_permille);
  if (timing.prescaler == 0) return CanError::kBitTiming;
  regs_.mcr.replace(mcr::kSleep, mcr::kInrq);  // 32.4.1: out of sleep and into initialisation
  if (!wait_set(regs_.msr, msr::kInak) || !wait_clear(regs_.msr, msr::kSlak)) return CanError::kNoInit;
  // Retransmission as ISO 11898-1 has it; no recovery of its own (ABOM): it is counted, and old frames go before it.
  // TXFP: in the order of the requests, not of the identifiers. RFLM: a full FIFO loses the newest frame.
  regs_.mcr.write(mcr::kInrq | mcr::kTxfp | mcr::kRflm);
  regs_.btr.write((timing.prescaler - 1U) | (timing.segment1 - 1U) << 16 | (timing.segment2 - 1U) << 20 |
                  (timing.jump - 1U) << 24);
  const CanError filters = set_filters(config, rows, count);
  if (filters != CanError::kNone) return filters;
  ready_ = true;
  regs_.ier.write(ier::kFmpie0 | ier::kFmpie1 | ier::kFovie0 | ier::kFovie1 | ier::kTmeie);
  regs_.mcr.clear(mcr::kInrq);
  return wait_clear(regs_.msr, msr::kInak) ? CanError::kNone : CanError::kNotOnBus;
}

void BxCan::on_receive_interrupt() {
  take_from_fifo(0);
  take_from_fifo(1);
}

void BxCan::take_from_fifo(std::size_t fifo) {
  Register& status = regs_.rfr[fifo];
  for (std::size_t i = 0; i < stm32::kFifoDepth && (status.read() & rfr::kFmp) != 0; ++i) {
    const RxMailbox& box = regs_.rx[fifo];
    const std::uint32_t id = box.ri.read();
    const bool ext = (id & mailbox::kIde) != 0;
    Frame frame;
    frame.id = ext ? id >> mailbox::kExtendedShift | Frame::kExtendedFlag : id >> mailbox::kStandardShift;
    const std::uint32_t dlc = box.rdt.read() & mailbox::kDlc;
    frame.dlc = static_cast<std::uint8_t>(dlc < Frame::kMaxBytes ? dlc : Frame::kMaxBytes);
    stm32::put_word(frame, 0, box.rdl.read());
    stm32::put_word(frame, 4, box.rdh.read());
    status.write(rfr::kRfom);  // no read-modify-write: FULL and FOVR are cleared by writing ones
    static_cast<void>(wait_clear(status, rfr::kRfom, kReleaseReads));
    if ((id & mailbox::kRtr) != 0) continue;  // the filters ask for data frames; nothing depends on them alone
    take(frame);
  }
  if ((status.read() & rfr::kFovr) != 0) {
    ++counts_.overruns;
    status.write(rfr::kFovr | rfr::kFull);
  }
}

void BxCan::load(std::size_t box, const Frame& frame) {
  TxMailbox& out = regs_.tx[box];
  const std::uint32_t id = stm32::extended(frame)
                               ? (frame.id & kExtendedMask) << mailbox::kExtendedShift | mailbox::kIde
                               : (frame.id & kStandardMask) << mailbox::kStandardShift;
  out.ti.write(id);
  out.tdt.write(frame.dlc);
  out.tdl.write(stm32::word_of(frame, 0));
  out.tdh.write(stm32::word_of(frame, 4));
  out.ti.write(id | mailbox::kTxrq);
}

void BxCan::fill() {
  for (std::size_t box = 0; box < stm32::kMailboxes; ++box) {
    if ((regs_.tsr.read() & tsr::kTme0 << box) == 0) continue;
    Frame frame;
    if (!next(frame)) return;
    load(box, frame);
    ++counts_.sent;
  }
}

/// Taken while send() has it off (it was pending by then), it does nothing: send() fills the mailboxes itself.
void BxCan::on_transmit_interrupt() {
  if ((regs_.ier.read() & ier::kTmeie) == 0) return;
  regs_.tsr.write(tsr::kRqcp0 | tsr::kRqcp0 << 8 | tsr::kRqcp0 << 16);
  fill();
}

void BxCan::let_sending_interrupt(bool on) {
  if (on) {
    regs_.ier.set(ier::kTmeie);
  } else {
    regs_.ier.clear(ier::kTmeie);
  }
}

std::uint32_t BxCan::abort_waiting() {
  const std::uint32_t status = regs_.tsr.read();
  std::uint32_t abort = 0, waiting = 0;
  for (std::size_t box = 0; box < stm32::kMailboxes; ++box) {
    if ((status & tsr::kTme0 << box) != 0) continue;
    abort |= tsr::kAbrq0 << (8 * box);
    ++waiting;
  }
  if (abort != 0) regs_.tsr.write(abort);
  return waiting;
}

/// 32.7.6: with ABOM off, entering and leaving initialisation starts the recovery, 128 times 11 recessive bits. One
/// hand-shake a step, none of them waited for.
void BxCan::leave_bus_off() {
  const bool boff = (regs_.esr.read() & esr::kBoff) != 0;
  if (!off_) {
    if (!boff) return;
    ++counts_.bus_off;
    off_ = true;
    regs_.mcr.set(mcr::kInrq);
    return;
  }
  if ((regs_.msr.read() & msr::kInak) != 0) {
    regs_.mcr.clear(mcr::kInrq);
    return;
  }
  if (boff || (regs_.mcr.read() & mcr::kInrq) != 0) return;
  off_ = false;
  ++counts_.recovered;
}

}  // namespace voltlap::port::stm32f4
