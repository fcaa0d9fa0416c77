// SPDX-License-Identifier: Apache-2.0
#include "fake_bxcan.hpp"

namespace voltlap::port::stm32f4::test {
namespace {

constexpr std::size_t kTx = 0x180, kRx = 0x1B0, kRxEnd = 0x1D0, kBanks = 0x240;

bool extended(const Frame& f) { return (f.id & Frame::kExtendedFlag) != 0; }

std::uint32_t identifier_word(const Frame& f, bool remote) {
  const std::uint32_t rtr = remote ? 2U : 0U;
  return extended(f) ? (f.id & 0x1FFF'FFFFU) << 3 | 4U | rtr : (f.id & 0x7FFU) << 21 | rtr;
}
/// As a 16-bit filter sees it: STID, RTR, IDE, EXID[17:15].
std::uint32_t short_word(const Frame& f, bool remote) {
  const std::uint32_t rtr = remote ? 1U << 4 : 0U;
  if (!extended(f)) return (f.id & 0x7FFU) << 5 | rtr;
  const std::uint32_t id = f.id & 0x1FFF'FFFFU;
  return (id >> 18) << 5 | rtr | 1U << 3 | (id >> 15 & 7U);
}
Frame frame_of(const std::uint32_t (&w)[4]) {
  Frame f;
  f.id = (w[0] & 4U) != 0 ? w[0] >> 3 | Frame::kExtendedFlag : w[0] >> 21;
  f.dlc = static_cast<std::uint8_t>(w[1] & 0xFU);
  for (std::size_t i = 0; i < f.dlc && i < 8; ++i) f.data[i] = static_cast<std::uint8_t>(w[2 + i / 4] >> (8 * (i % 4)));
  return f;
}

}  // namespace

std::uint32_t FakeBxCan::tsr() const {
  std::uint32_t out = 0;
  for (unsigned i = 0; i < 3; ++i) {
    out |= (tx_[i].rqcp ? 1U : 0U) << (8 * i) | (tx_[i].txok ? 2U : 0U) << (8 * i);
    out |= (tx_[i].pending ? 0U : 1U) << (26 + i);
  }
  return out;
}

std::uint32_t FakeBxCan::read(std::size_t offset) {
  if (!clocked) return 0;
  if (offset >= kBanks) return bank_[(offset - kBanks) / 8][(offset - kBanks) / 4 % 2];
  if (offset >= kTx && offset < kRx) {
    const Mailbox& box = tx_[(offset - kTx) / 16];
    const std::size_t word = (offset - kTx) / 4 % 4;
    return box.words[word] | (word == 0 && box.pending ? 1U : 0U);
  }
  if (offset >= kRx && offset < kRxEnd) {
    const Fifo& fifo = fifo_[(offset - kRx) / 16];
    return fifo.frames.empty() ? 0U : fifo.frames.front()[(offset - kRx) / 4 % 4];
  }
  switch (offset) {
    case 0x000: return mcr_;
    case 0x004:
      // 32.4.2: it leaves initialisation when it has seen 11 recessive bits, and bus-off by recovery alone.
      if ((mcr_ & mcr::kInrq) == 0 && bus_recessive) inak_ = false;
      if (slak_ && (mcr_ & mcr::kSleep) == 0) slak_ = false;
      return (inak_ ? msr::kInak : 0U) | (slak_ ? msr::kSlak : 0U) | 0xC00U;
    case 0x008: return tsr();
    case 0x00C:
    case 0x010: {
      const Fifo& f = fifo_[(offset - 0x00C) / 4];
      return static_cast<std::uint32_t>(f.frames.size()) | (f.full ? rfr::kFull : 0U) | (f.overrun ? rfr::kFovr : 0U) |
             (release_sticks ? rfr::kRfom : 0U);
    }
    case 0x014: return ier_;
    case 0x018: return bus_off_ ? esr::kBoff | 255U << 16 : 0U;
    case 0x01C: return btr_;
    case 0x200: return fmr_;
    case 0x204: return fm1r_;
    case 0x20C: return fs1r_;
    case 0x214: return ffa1r_;
    case 0x21C: return fa1r_;
    default: return 0;
  }
}

void FakeBxCan::write_mcr(std::uint32_t value) {
  const bool was = (mcr_ & mcr::kInrq) != 0;
  mcr_ = value & 0x0001'80FFU;
  const bool now = (mcr_ & mcr::kInrq) != 0;
  if (now && clocked) inak_ = true;
  if (was && !now && bus_off_) recovering_ = true;  // 32.7.6: entering and leaving initialisation
}

void FakeBxCan::write_tsr(std::uint32_t value) {
  for (unsigned i = 0; i < 3; ++i) {
    const std::uint32_t bits = value >> (8 * i);
    if ((bits & 1U) != 0) tx_[i].rqcp = tx_[i].txok = false;  // writing RQCP clears TXOK, ALST, TERR as well
    if ((bits & tsr::kAbrq0) != 0 && tx_[i].pending) {
      tx_[i].pending = false;
      tx_[i].rqcp = true;
      tx_[i].txok = false;
    }
  }
}

void FakeBxCan::write_fifo(std::size_t fifo, std::uint32_t value) {
  Fifo& f = fifo_[fifo];
  if ((value & rfr::kFull) != 0) f.full = false;
  if ((value & rfr::kFovr) != 0) f.overrun = false;
  if ((value & rfr::kRfom) != 0 && !f.frames.empty() && !release_sticks) {
    f.frames.pop_front();
    f.full = false;
  }
}

void FakeBxCan::write_mailbox(std::size_t offset, std::uint32_t value) {
  Mailbox& box = tx_[(offset - kTx) / 16];
  if (box.pending) return;  // 32.7.1: no write access while it is not empty
  const std::size_t word = (offset - kTx) / 4 % 4;
  box.words[word] = word == 0 ? value & ~1U : value;
  if (word != 0 || (value & 1U) == 0) return;
  box.pending = true;
  box.order = requests_++;
}

void FakeBxCan::write_filter(std::size_t offset, std::uint32_t value) {
  const std::uint32_t mask = (1U << kFilterBanks) - 1U;
  const bool finit = (fmr_ & fmr::kFinit) != 0;
  if (offset >= kBanks) {
    const std::size_t bank = (offset - kBanks) / 8;
    if (finit || (fa1r_ >> bank & 1U) == 0) bank_[bank][(offset - kBanks) / 4 % 2] = value;
    return;
  }
  switch (offset) {
    case 0x200: fmr_ = (value & 0x3F01U) | 0x2A1C'0000U; break;
    case 0x204: fm1r_ = finit ? value & mask : fm1r_; break;
    case 0x20C: fs1r_ = finit ? value & mask : fs1r_; break;
    case 0x214: ffa1r_ = finit ? value & mask : ffa1r_; break;
    case 0x21C: fa1r_ = value & mask; break;
    default: break;
  }
}

void FakeBxCan::write(std::size_t offset, std::uint32_t value) {
  if (!clocked) return;
  if (offset >= 0x200) return write_filter(offset, value);
  if (offset >= kTx && offset < kRx) return write_mailbox(offset, value);
  switch (offset) {
    case 0x000: write_mcr(value); break;
    case 0x008: write_tsr(value); break;
    case 0x00C:
    case 0x010: write_fifo((offset - 0x00C) / 4, value); break;
    case 0x014: ier_ = value; break;
    case 0x01C: btr_ = inak_ ? value : btr_; break;  // 32.9.2: in initialisation only
    default: break;                                  // MSR holds only flags; ESR, mailboxes of reception are read-only
  }
}

std::optional<Frame> FakeBxCan::transmit_one() {
  if (inak_ || slak_ || bus_off_) return std::nullopt;
  Mailbox* next = nullptr;
  for (Mailbox& box : tx_) {
    if (!box.pending) continue;
    const bool by_request = (mcr_ & mcr::kTxfp) != 0;
    if (next == nullptr || (by_request ? box.order < next->order : box.words[0] < next->words[0])) next = &box;
  }
  if (next == nullptr) return std::nullopt;
  next->pending = false;
  next->rqcp = next->txok = true;
  return frame_of(next->words);
}

bool FakeBxCan::filter_takes(const Frame& frame, bool remote, std::size_t& fifo) const {
  if ((fmr_ & fmr::kFinit) != 0) return false;
  for (std::size_t b = 0; b < kFilterBanks; ++b) {
    if ((fa1r_ >> b & 1U) == 0) continue;
    const bool list = (fm1r_ >> b & 1U) != 0;
    const std::uint32_t r1 = bank_[b][0], r2 = bank_[b][1];
    bool hit = false;
    if ((fs1r_ >> b & 1U) != 0) {
      const std::uint32_t id = identifier_word(frame, remote) & ~1U;
      hit = list ? id == (r1 & ~1U) || id == (r2 & ~1U) : ((id ^ r1) & r2 & ~1U) == 0;
    } else {
      const std::uint32_t id = short_word(frame, remote);
      const std::uint32_t a = r1 & 0xFFFFU, c = r1 >> 16, d = r2 & 0xFFFFU, e = r2 >> 16;
      hit = list ? id == a || id == c || id == d || id == e : ((id ^ a) & c) == 0 || ((id ^ d) & e) == 0;
    }
    if (!hit) continue;
    fifo = ffa1r_ >> b & 1U;
    return true;
  }
  return false;
}

bool FakeBxCan::arrive(const Frame& frame, bool remote) {
  std::size_t at = 0;
  if (inak_ || slak_ || bus_off_ || !filter_takes(frame, remote, at)) return false;
  Fifo& f = fifo_[at];
  std::array<std::uint32_t, 4> words = {identifier_word(frame, remote), frame.dlc, 0, 0};
  for (std::size_t i = 0; i < 8; ++i) words[2 + i / 4] |= std::uint32_t{frame.data[i]} << (8 * (i % 4));
  if (f.frames.size() == 3) {
    f.overrun = true;
    if ((mcr_ & mcr::kRflm) == 0) f.frames.back() = words;  // 32.7.3: without the lock the newest one is written over
    return true;
  }
  f.frames.push_back(words);
  f.full = f.frames.size() == 3;
  return true;
}

void FakeBxCan::recessive_bits() {
  if (bus_off_ && recovering_) bus_off_ = recovering_ = false;
}

bool FakeBxCan::transmit_interrupt() const {
  return (ier_ & ier::kTmeie) != 0 && (tx_[0].rqcp || tx_[1].rqcp || tx_[2].rqcp);
}
bool FakeBxCan::receive_interrupt() const {
  const bool first = (ier_ & ier::kFmpie0) != 0 && !fifo_[0].frames.empty();
  const bool second = (ier_ & ier::kFmpie1) != 0 && !fifo_[1].frames.empty();
  return first || second || ((ier_ & ier::kFovie0) != 0 && fifo_[0].overrun) ||
         ((ier_ & ier::kFovie1) != 0 && fifo_[1].overrun);
}

}  // namespace voltlap::port::stm32f4::test
