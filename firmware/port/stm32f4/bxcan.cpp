// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/bxcan.hpp"

namespace voltlap::port::stm32f4 {
namespace {

using stm32::wait_clear;
using stm32::wait_set;

constexpr std::uint32_t kStandardMask = 0x7FFU, kExtendedMask = 0x1FFF'FFFFU;
constexpr std::uint32_t kReleaseReads = 16;  // RFOM falls within a few clocks of APB1
constexpr std::size_t kIdsPerShortBank = 4, kIdsPerLongBank = 2;

/// 32.7.4: in a bank of four 16-bit identifiers, STID stands in bits 15:5; RTR and IDE are 0.
std::uint32_t short_filter(std::uint32_t id) { return (id & kStandardMask) << 5; }
/// In one of two 32-bit identifiers.
std::uint32_t long_filter(std::uint32_t id) {
  return (id & kExtendedMask) << mailbox::kExtendedShift | mailbox::kIde;
}
bool is_extended(std::uint32_t id) { return (id & Frame::kExtendedFlag) != 0; }

/// The next `count` rows of one kind, from `at` on; a bank that is not full repeats its last.
std::size_t next_ids(const can::MessageRow* rows, std::size_t rows_count, bool ext, std::size_t& at,
                     std::uint32_t* ids, std::size_t count) {
  std::size_t found = 0;
  for (; at < rows_count && found < count; ++at) {
    if (is_extended(rows[at].id) == ext) ids[found++] = rows[at].id;
  }
  for (std::size_t i = found; i < count && found > 0; ++i) ids[i] = ids[found - 1];
  return found;
}

}  // namespace

CanError BxCan::set_filters(const Config& config, const can::MessageRow* rows, std::size_t count) {
  std::size_t bank = config.bank_first;
  const std::size_t end = config.bank_first + config.banks;
  if (end > kFilterBanks) return CanError::kFilters;
  std::uint32_t own = 0;
  for (std::size_t i = bank; i < end; ++i) own |= 1U << i;
  filters_.fmr.set(fmr::kFinit);  // filters may be written now; reception of both controllers rests
  filters_.fa1r.clear(own);
  filters_.fm1r.set(own);  // identifier lists: exactly what the table names
  std::uint32_t ids[kIdsPerShortBank] = {};
  std::uint32_t used = 0;
  bool fit = true;
  for (std::size_t at = 0; fit && next_ids(rows, count, false, at, ids, kIdsPerShortBank) > 0; ++bank) {
    fit = bank < end;
    if (!fit) break;
    filters_.fs1r.clear(1U << bank);
    filters_.ffa1r.clear(1U << bank);  // FIFO 0
    filters_.bank[bank].r1.write(short_filter(ids[0]) | short_filter(ids[1]) << 16);
    filters_.bank[bank].r2.write(short_filter(ids[2]) | short_filter(ids[3]) << 16);
    used |= 1U << bank;
  }
  for (std::size_t at = 0; fit && next_ids(rows, count, true, at, ids, kIdsPerLongBank) > 0; ++bank) {
    fit = bank < end;
    if (!fit) break;
    filters_.fs1r.set(1U << bank);
    filters_.ffa1r.set(1U << bank);  // FIFO 1: a long identifier waits for no short one
    filters_.bank[bank].r1.write(long_filter(ids[0]));
    filters_.bank[bank].r2.write(long_filter(ids[1]));
    used |= 1U << bank;
  }
  if (fit) filters_.fa1r.set(used);
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

std::size_t BxCan::receive(Frame* frames, std::size_t capacity) { return stm32::take_all(inbox_, frames, capacity); }

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
    ++counts_.received;
    if (!inbox_.push(frame)) ++counts_.inbox_full;
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

void BxCan::fill_mailboxes() {
  for (std::size_t box = 0; box < stm32::kMailboxes; ++box) {
    if ((regs_.tsr.read() & tsr::kTme0 << box) == 0) continue;
    Frame frame;
    if (!outbox_.pop(frame)) return;
    load(box, frame);
    ++counts_.sent;
  }
}

void BxCan::on_transmit_interrupt() {
  regs_.tsr.write(tsr::kRqcp0 | tsr::kRqcp0 << 8 | tsr::kRqcp0 << 16);
  fill_mailboxes();
}

/// With the interrupt of transmission off. True when nothing had to be dropped.
bool BxCan::drop_old() {
  std::uint32_t dropped = 0;
  const std::uint32_t status = regs_.tsr.read();
  std::uint32_t abort = 0;
  for (std::size_t box = 0; box < stm32::kMailboxes; ++box) {
    if ((status & tsr::kTme0 << box) != 0) continue;
    abort |= tsr::kAbrq0 << (8 * box);
    ++dropped;
  }
  // One that is on the bus this moment still goes out whole; a mailbox that waits is empty at once.
  if (abort != 0) regs_.tsr.write(abort);
  for (Frame frame; outbox_.pop(frame);) ++dropped;
  counts_.dropped += dropped;
  return dropped == 0;
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

bool BxCan::send(const TxQueue& frames) {
  if (!ready_) return frames.size() == 0;
  regs_.ier.clear(ier::kTmeie);
  leave_bus_off();
  bool all = drop_old();
  for (const Frame& frame : frames) {
    if (!off_ && outbox_.push(frame)) continue;
    ++counts_.dropped;
    all = false;
  }
  if (!off_) fill_mailboxes();
  regs_.ier.set(ier::kTmeie);
  return all;
}

}  // namespace voltlap::port::stm32f4
