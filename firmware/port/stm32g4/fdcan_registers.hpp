// SPDX-License-Identifier: Apache-2.0
// One FDCAN of the STM32G4 and its part of the message RAM: RM0440 (rev 8) 44.4 "FDCAN registers", message RAM 44.3.8.
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32g4 {

using stm32::Register;

struct FdCanRegisters {
  Register crel, endn, reserved0, dbtp, test, rwd;  // 0x000 to 0x014
  Register cccr;                                    // 0x018 CC control
  Register nbtp;                                    // 0x01C nominal bit timing
  Register tscc, tscv, tocc, tocv, reserved1[4];
  Register ecr;  // 0x040 error counters
  Register psr;  // 0x044 protocol status; a read resets the last error code
  Register tdcr, reserved2;
  Register ir;   // 0x050 interrupts; written with ones to clear
  Register ie;   // 0x054
  Register ils;  // 0x058 which line
  Register ile;  // 0x05C
  Register reserved3[8];
  Register rxgfc;  // 0x080 global filter
  Register xidam;  // 0x084
  Register hpms, reserved4;
  struct Fifo {
    Register status;       // RXFnS
    Register acknowledge;  // RXFnA
  } rx[2];                 // 0x090
  Register reserved5[8];
  Register txbc;   // 0x0C0
  Register txfqs;  // 0x0C4
  Register txbrp;  // 0x0C8 requests pending
  Register txbar;  // 0x0CC add request
  Register txbcr;  // 0x0D0 cancel
  Register txbto, txbcf;
  Register txbtie;  // 0x0DC
  Register txbcie, txefs, txefa;
};
static_assert(offsetof(FdCanRegisters, cccr) == 0x018 && offsetof(FdCanRegisters, nbtp) == 0x01C);
static_assert(offsetof(FdCanRegisters, ecr) == 0x040 && offsetof(FdCanRegisters, psr) == 0x044);
static_assert(offsetof(FdCanRegisters, ir) == 0x050 && offsetof(FdCanRegisters, ile) == 0x05C);
static_assert(offsetof(FdCanRegisters, rxgfc) == 0x080 && offsetof(FdCanRegisters, rx) == 0x090);
static_assert(offsetof(FdCanRegisters, txbc) == 0x0C0 && offsetof(FdCanRegisters, txbar) == 0x0CC);
static_assert(offsetof(FdCanRegisters, txbtie) == 0x0DC && offsetof(FdCanRegisters, txefa) == 0x0E8);

inline constexpr std::size_t kStandardFilters = 28, kExtendedFilters = 8;

struct ExtendedFilter {
  Register f0, f1;
};
struct Element {  // of a receive FIFO or a transmit buffer: two words of head, 64 bytes of data
  Register head0, head1;
  Register data[16];
};
struct MessageRam {  // 212 words for each FDCAN, from 0x4000 A400 on
  Register standard[kStandardFilters];
  ExtendedFilter extended[kExtendedFilters];
  Element rx[2][3];
  Register tx_event[3][2];
  Element tx[3];
};
static_assert(offsetof(MessageRam, extended) == 0x070 && offsetof(MessageRam, rx) == 0x0B0);
static_assert(offsetof(MessageRam, tx_event) == 0x260 && offsetof(MessageRam, tx) == 0x278);
static_assert(sizeof(MessageRam) == 0x350);

namespace cccr {
inline constexpr std::uint32_t kInit = 1U << 0, kCce = 1U << 1, kCsa = 1U << 3, kCsr = 1U << 4, kDar = 1U << 6,
                               kTest = 1U << 7, kFdoe = 1U << 8, kBrse = 1U << 9;
}
namespace psr {
inline constexpr std::uint32_t kEp = 1U << 5, kBo = 1U << 7;
}
namespace ir {
inline constexpr std::uint32_t kRf0n = 1U << 0, kRf0l = 1U << 2, kRf1n = 1U << 3, kRf1l = 1U << 5, kTc = 1U << 7,
                               kTcf = 1U << 8;
}
namespace rxgfc {  // both kinds: what no filter names, and remote frames, are refused
inline constexpr std::uint32_t kRejectAll = 1U << 0 | 1U << 1 | 2U << 2 | 2U << 4;
inline constexpr unsigned kLssShift = 16, kLseShift = 24;
}
namespace fifo {
inline constexpr std::uint32_t kFill = 0xFU;
inline constexpr unsigned kGetShift = 8;
}
namespace txfqs {
inline constexpr std::uint32_t kFull = 1U << 21;
inline constexpr unsigned kPutShift = 16;
}
namespace element {
inline constexpr std::uint32_t kXtd = 1U << 30, kRtr = 1U << 29;
inline constexpr unsigned kStandardShift = 18, kDlcShift = 16;
}
namespace filter {  // 44.3.9: from one identifier to another, both belonging to it
inline constexpr std::uint32_t kRange = 0U << 30, kStandardFifo0 = 1U << 27, kExtendedFifo1 = 2U << 29;
inline constexpr unsigned kFirstShift = 16;
inline constexpr std::uint32_t kExtendedRangeUnmasked = 3U << 30;
}

}  // namespace voltlap::port::stm32g4
