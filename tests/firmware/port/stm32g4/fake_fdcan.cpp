// SPDX-License-Identifier: Apache-2.0
#include "fake_fdcan.hpp"

namespace voltlap::port::stm32g4::test {
namespace {

bool extended(const Frame& f) { return (f.id & Frame::kExtendedFlag) != 0; }
std::uint32_t id_of(const Frame& f) { return f.id & 0x1FFF'FFFFU; }

/// A filter's kind, by SFT or EFT.
bool matches(std::uint32_t type, std::uint32_t id, std::uint32_t a, std::uint32_t b) {
  switch (type) {
    case 0:
    case 3: return a <= id && id <= b;  // 3 is "disabled" of the standard ones, sorted out before
    case 1: return id == a || id == b;
    default: return (id & b) == (a & b);
  }
}

}  // namespace

std::uint32_t FakeFdCan::read(std::size_t offset) {
  if (!clocked) return 0;
  switch (offset) {
    case 0x018: return cccr_;
    case 0x01C: return nbtp_;
    case 0x044: return bus_off_ ? psr::kBo | psr::kEp | 1U << 6 : 7U;
    case 0x050: return ir_;
    case 0x054: return ie_;
    case 0x05C: return ile_;
    case 0x080: return rxgfc_;
    case 0x090:
    case 0x098: {
      const Fifo& f = fifo_[(offset - 0x090) / 8];
      const std::uint32_t full = f.fill == 3 ? 1U << 24 : 0U, lost = f.lost ? 1U << 25 : 0U;
      return f.fill | f.get << 8 | (f.get + f.fill) % 3 << 16 | full | lost;
    }
    case 0x0C0: return txbc_;
    case 0x0C4: return get_ << 8 | put_ << 16 | ((pending_ >> put_ & 1U) != 0 ? txfqs::kFull : 0U);
    case 0x0C8: return pending_;
    case 0x0DC: return txbtie_;
    case 0x0E0: return txbcie_;
    default: return 0;
  }
}

void FakeFdCan::write_cccr(std::uint32_t value) {
  // CCE is writable while INIT is set; what it protects only with both (44.4.6).
  const std::uint32_t guarded = cccr::kFdoe | cccr::kBrse | cccr::kDar | 1U << 12 | 1U << 13 | 1U << 14;
  const bool was_init = (cccr_ & cccr::kInit) != 0;
  if (configurable()) cccr_ = (cccr_ & ~guarded) | (value & guarded);
  if (was_init) cccr_ = (cccr_ & ~cccr::kCce) | (value & cccr::kCce);
  if ((value & cccr::kInit) != 0) {
    cccr_ |= cccr::kInit;
  } else if (bus_recessive) {
    cccr_ &= ~(cccr::kInit | cccr::kCce);
  }
}

void FakeFdCan::cancel(std::uint32_t buffers) {
  if ((buffers & pending_) == 0) return;
  pending_ &= ~buffers;
  while (pending_ == 0 && get_ != put_) get_ = (get_ + 1) % 3;
  if ((txbcie_ & buffers) != 0) ir_ |= ir::kTcf;
}

void FakeFdCan::write(std::size_t offset, std::uint32_t value) {
  if (!clocked) return;
  switch (offset) {
    case 0x018: write_cccr(value); break;
    case 0x01C: nbtp_ = configurable() ? value : nbtp_; break;
    case 0x050: ir_ &= ~value; break;
    case 0x054: ie_ = value; break;
    case 0x05C: ile_ = value & 3U; break;
    case 0x080: rxgfc_ = configurable() ? value : rxgfc_; break;
    case 0x094:
    case 0x09C: {
      Fifo& f = fifo_[(offset - 0x094) / 8];
      if (f.fill == 0 || (value & 7U) != f.get) break;
      f.get = (f.get + 1) % 3;
      --f.fill;
      f.lost = false;
      break;
    }
    case 0x0C0: txbc_ = configurable() ? value : txbc_; break;
    case 0x0CC:
      if ((cccr_ & cccr::kInit) != 0) break;
      for (std::uint32_t i = 0; i < 3; ++i) {
        if ((value >> put_ & 1U) == 0) break;
        value &= ~(1U << put_);
        pending_ |= 1U << put_;
        put_ = (put_ + 1) % 3;
      }
      break;
    case 0x0D0: cancel(value); break;
    case 0x0DC: txbtie_ = value & 7U; break;
    case 0x0E0: txbcie_ = value & 7U; break;
    default: break;
  }
}

std::optional<Frame> FakeFdCan::transmit_one() {
  if (in_init() || bus_off_ || pending_ == 0) return std::nullopt;
  while ((pending_ >> get_ & 1U) == 0) get_ = (get_ + 1) % 3;
  const std::uint32_t at = get_;
  pending_ &= ~(1U << at);
  get_ = (get_ + 1) % 3;
  if ((txbtie_ >> at & 1U) != 0) ir_ |= ir::kTc;
  const Element& e = ram.tx[at];
  const std::uint32_t head = e.head0.read();
  Frame f;
  f.id = (head & element::kXtd) != 0 ? (head & 0x1FFF'FFFFU) | Frame::kExtendedFlag : head >> 18 & 0x7FFU;
  f.dlc = static_cast<std::uint8_t>(e.head1.read() >> 16 & 0xFU);
  for (std::size_t i = 0; i < f.dlc; ++i) f.data[i] = static_cast<std::uint8_t>(e.data[i / 4].read() >> (8 * (i % 4)));
  return f;
}

int FakeFdCan::fifo_for(const Frame& frame, bool remote) const {
  if (extended(frame)) {
    if (remote && (rxgfc_ & 1U) != 0) return -1;
    for (std::uint32_t i = 0; i < (rxgfc_ >> 24 & 0xFU); ++i) {
      const std::uint32_t f0 = ram.extended[i].f0.read(), f1 = ram.extended[i].f1.read();
      if (!matches(f1 >> 30, id_of(frame), f0 & 0x1FFF'FFFFU, f1 & 0x1FFF'FFFFU)) continue;
      return static_cast<int>(f0 >> 29) - 1;
    }
    return (rxgfc_ >> 2 & 3U) < 2 ? static_cast<int>(rxgfc_ >> 2 & 3U) : -1;
  }
  if (remote && (rxgfc_ & 2U) != 0) return -1;
  for (std::uint32_t i = 0; i < (rxgfc_ >> 16 & 0x1FU); ++i) {
    const std::uint32_t f = ram.standard[i].read();
    if (f >> 30 == 3 || !matches(f >> 30, id_of(frame), f >> 16 & 0x7FFU, f & 0x7FFU)) continue;
    return static_cast<int>(f >> 27 & 7U) - 1;
  }
  return (rxgfc_ >> 4 & 3U) < 2 ? static_cast<int>(rxgfc_ >> 4 & 3U) : -1;
}

bool FakeFdCan::arrive(const Frame& frame, bool remote) {
  const int at = in_init() || bus_off_ ? -1 : fifo_for(frame, remote);
  if (at < 0 || at > 1) return false;
  Fifo& f = fifo_[at];
  if (f.fill == 3) {  // blocking mode: the newest is lost
    f.lost = true;
    ir_ |= at == 0 ? ir::kRf0l : ir::kRf1l;
    return true;
  }
  Element& e = ram.rx[at][(f.get + f.fill) % 3];
  e.head0.write((extended(frame) ? id_of(frame) | element::kXtd : id_of(frame) << 18) | (remote ? element::kRtr : 0U));
  e.head1.write(std::uint32_t{frame.dlc} << 16 | 0xBEEFU);  // a time stamp below
  for (std::size_t w = 0; w < 2; ++w) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) word |= std::uint32_t{frame.data[4 * w + i]} << (8 * i);
    e.data[w].write(word);
  }
  ++f.fill;
  ir_ |= at == 0 ? ir::kRf0n : ir::kRf1n;
  return true;
}

void FakeFdCan::go_bus_off() {
  bus_off_ = true;
  cccr_ |= cccr::kInit;
}

void FakeFdCan::recessive_bits() {
  if (!in_init()) bus_off_ = false;
}

}  // namespace voltlap::port::stm32g4::test
