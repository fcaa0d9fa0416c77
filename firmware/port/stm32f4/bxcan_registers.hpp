// SPDX-License-Identifier: Apache-2.0
// The bxCAN of the STM32F4: RM0090 (rev 19) 32.9 "CAN registers", memory map in 32.9.5.
#pragma once
#include "port/stm32/register.hpp"

namespace voltlap::port::stm32f4 {

using stm32::Register;

struct TxMailbox {  // 32.9.3
  Register ti;      // CAN_TIxR
  Register tdt;     // CAN_TDTxR
  Register tdl;     // CAN_TDLxR
  Register tdh;     // CAN_TDHxR
};
struct RxMailbox {
  Register ri;   // CAN_RIxR
  Register rdt;  // CAN_RDTxR
  Register rdl;  // CAN_RDLxR
  Register rdh;  // CAN_RDHxR
};
struct FilterBank {  // 32.9.4
  Register r1, r2;   // CAN_FiR1, CAN_FiR2
};
inline constexpr std::size_t kFilterBanks = 28;  // of CAN1 and CAN2 together

struct BxCanRegisters {
  Register mcr;  // CAN_MCR
  Register msr;  // CAN_MSR
  Register tsr;  // CAN_TSR
  Register rfr[2];  // CAN_RF0R, CAN_RF1R
  Register ier;  // CAN_IER
  Register esr;  // CAN_ESR
  Register btr;  // CAN_BTR
  Register reserved0[88];
  TxMailbox tx[3];
  RxMailbox rx[2];
  Register reserved1[12];
  Register fmr;  // CAN_FMR
  Register fm1r;  // CAN_FM1R, mode: 1 identifier list
  Register reserved2;
  Register fs1r;  // CAN_FS1R, scale: 1 single 32-bit
  Register reserved3;
  Register ffa1r;  // CAN_FFA1R, FIFO of the bank
  Register reserved4;
  Register fa1r;  // CAN_FA1R, active
  Register reserved5[8];
  FilterBank bank[kFilterBanks];
};
static_assert(offsetof(BxCanRegisters, tsr) == 0x008 && offsetof(BxCanRegisters, rfr) == 0x00C);
static_assert(offsetof(BxCanRegisters, ier) == 0x014 && offsetof(BxCanRegisters, btr) == 0x01C);
static_assert(offsetof(BxCanRegisters, tx) == 0x180 && offsetof(BxCanRegisters, rx) == 0x1B0);
static_assert(offsetof(BxCanRegisters, fmr) == 0x200 && offsetof(BxCanRegisters, fm1r) == 0x204);
static_assert(offsetof(BxCanRegisters, fs1r) == 0x20C && offsetof(BxCanRegisters, ffa1r) == 0x214);
static_assert(offsetof(BxCanRegisters, fa1r) == 0x21C && offsetof(BxCanRegisters, bank) == 0x240);

namespace mcr {
inline constexpr std::uint32_t kInrq = 1U << 0, kSleep = 1U << 1, kTxfp = 1U << 2, kRflm = 1U << 3, kReset = 1U << 15;
}
namespace msr {
inline constexpr std::uint32_t kInak = 1U << 0, kSlak = 1U << 1, kErri = 1U << 2;
}
namespace tsr {  // the bits of mailbox n stand 8 n further up
inline constexpr std::uint32_t kRqcp0 = 1U << 0, kTxok0 = 1U << 1, kAbrq0 = 1U << 7, kTme0 = 1U << 26;
}
namespace rfr {
inline constexpr std::uint32_t kFmp = 3U << 0, kFull = 1U << 3, kFovr = 1U << 4, kRfom = 1U << 5;
}
namespace ier {
inline constexpr std::uint32_t kTmeie = 1U << 0, kFmpie0 = 1U << 1, kFovie0 = 1U << 3, kFmpie1 = 1U << 4,
                               kFovie1 = 1U << 6;
}
namespace esr {
inline constexpr std::uint32_t kEpvf = 1U << 1, kBoff = 1U << 2;
}
namespace fmr {
inline constexpr std::uint32_t kFinit = 1U << 0, kCan2sb = 0x3FU << 8;
inline constexpr unsigned kCan2sbShift = 8;
}
namespace mailbox {
inline constexpr std::uint32_t kTxrq = 1U << 0, kRtr = 1U << 1, kIde = 1U << 2, kDlc = 0xFU;
inline constexpr unsigned kStandardShift = 21, kExtendedShift = 3;
}

}  // namespace voltlap::port::stm32f4
