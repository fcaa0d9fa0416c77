// SPDX-License-Identifier: Apache-2.0
#include "app/uds_server.hpp"

#include "base/diagnostic_address.hpp"

namespace voltlap::app {
namespace {

// ISO 14229-1: services (table 2) and negative response codes (annex A)
constexpr std::uint8_t kSession = 0x10, kReset = 0x11, kReadFaults = 0x19, kReadData = 0x22, kTesterPresent = 0x3E;
constexpr std::uint8_t kPositive = 0x40, kNegative = 0x7F, kSuppress = 0x80;
constexpr std::uint8_t kServiceUnknown = 0x11, kFunctionUnknown = 0x12, kWrongLength = 0x13, kTooLong = 0x14,
                       kConditions = 0x22, kOutOfRange = 0x31;
constexpr std::uint16_t kSoftwareVersion = 0xF189, kImageName = 0xF195, kActiveSession = 0xF186;
constexpr std::uint8_t kDefaultSession = 0x01, kProgrammingSession = 0x02, kHardReset = 0x01;
constexpr std::uint8_t kCountByMask = 0x01, kFaultsByMask = 0x02, kSupported = 0x0A;
constexpr std::uint8_t kTestFailed = 1U << 0, kConfirmed = 1U << 3, kStatusKnown = kTestFailed | kConfirmed;
constexpr std::uint8_t kFormatIso14229 = 0x01;

std::uint8_t status_of(const UdsView& view, unsigned bit) {
  const bool now = (view.faults_now >> bit & 1U) != 0, latched = (view.faults_latched >> bit & 1U) != 0;
  return static_cast<std::uint8_t>((now ? kTestFailed : 0U) | (now || latched ? kConfirmed : 0U));
}

/// Of a request that is served: the positive answer may be left out; a negative one never is.
bool suppressed(const std::uint8_t* request) {
  const bool has_function = request[0] == kSession || request[0] == kReset || request[0] == kReadFaults ||
                            request[0] == kTesterPresent;
  return has_function && (request[1] & kSuppress) != 0;
}

}  // namespace

void UdsServer::Answer::add(std::uint8_t byte) {
  if (count < sizeof bytes) {
    bytes[count++] = byte;
  } else {
    too_long = true;
  }
}

void UdsServer::Answer::add_text(const char* text) {
  for (; *text != '\0'; ++text) add(static_cast<std::uint8_t>(*text));
}

// DIA-006: the address is all that tells one node's server from another's.
UdsServer::UdsServer(std::uint8_t address, const UdsIdentity& identity)
    : identity_(identity),
      transport_(diagnostic_id(address, kTesterAddress), diagnostic_id(kTesterAddress, address)) {}

// DIA-001
std::uint8_t UdsServer::read_data(Answer& out) const {
  const std::size_t count = transport_.request_bytes();
  if (count < 3 || count % 2 == 0) return kWrongLength;
  bool known = false;
  for (std::size_t i = 1; i < count; i += 2) {
    const auto id = static_cast<std::uint16_t>(transport_.request()[i] << 8 | transport_.request()[i + 1]);
    if (id != kSoftwareVersion && id != kImageName && id != kActiveSession) continue;
    known = true;
    out.add(static_cast<std::uint8_t>(id >> 8));
    out.add(static_cast<std::uint8_t>(id));
    if (id == kSoftwareVersion) out.add_text(identity_.software_version);
    if (id == kImageName) out.add_text(identity_.image_name);
    if (id == kActiveSession) out.add(kDefaultSession);
  }
  return known ? 0 : kOutOfRange;
}

// DIA-002
std::uint8_t UdsServer::read_faults(const UdsView& view, Answer& out) const {
  const std::size_t count = transport_.request_bytes();
  if (count < 2) return kWrongLength;
  const std::uint8_t function = transport_.request()[1] & static_cast<std::uint8_t>(~kSuppress);
  const bool by_mask = function == kCountByMask || function == kFaultsByMask;
  if (!by_mask && function != kSupported) return kFunctionUnknown;
  if (count != (by_mask ? 3U : 2U)) return kWrongLength;
  const std::uint8_t mask = transport_.request()[2];
  out.add(function);
  out.add(kStatusKnown);
  std::uint8_t found = 0;
  for (unsigned code = 0; code < identity_.faults.count; ++code) {
    const std::uint8_t status = status_of(view, (code + identity_.faults.first) % identity_.faults.count);
    if (by_mask && (status & mask) == 0) continue;
    ++found;
    if (function == kCountByMask) continue;
    out.add(identity_.faults.group);
    out.add(static_cast<std::uint8_t>(code));
    out.add(0);  // no failure type
    out.add(status);
  }
  if (function == kCountByMask) {
    out.add(kFormatIso14229);
    out.add(0);
    out.add(found);
  }
  return 0;
}

// DIA-003
std::uint8_t UdsServer::change_session(const UdsView& view, Answer& out) {
  if (transport_.request_bytes() != 2) return kWrongLength;
  const std::uint8_t session = transport_.request()[1] & static_cast<std::uint8_t>(~kSuppress);
  if (session != kDefaultSession && session != kProgrammingSession) return kFunctionUnknown;
  if (session == kProgrammingSession) {
    if (!view.may_restart) return kConditions;
    restart_ = UdsRestart::kBootLoader;
  }
  out.add(session);
  const std::uint8_t times[4] = {0x00, 0x32, 0x01, 0xF4};  // P2 50 ms, P2* 5 s
  for (const std::uint8_t byte : times) out.add(byte);
  return 0;
}

std::uint8_t UdsServer::reset(const UdsView& view, Answer& out) {
  if (transport_.request_bytes() != 2) return kWrongLength;
  const std::uint8_t function = transport_.request()[1] & static_cast<std::uint8_t>(~kSuppress);
  if (function != kHardReset) return kFunctionUnknown;
  if (!view.may_restart) return kConditions;
  restart_ = UdsRestart::kReset;
  out.add(function);
  return 0;
}

std::uint8_t UdsServer::tester_present(Answer& out) const {
  if (transport_.request_bytes() != 2) return kWrongLength;
  if ((transport_.request()[1] & static_cast<std::uint8_t>(~kSuppress)) != 0) return kFunctionUnknown;
  out.add(0);
  return 0;
}

std::uint8_t UdsServer::serve(const UdsView& view, Answer& out) {
  switch (transport_.request()[0]) {
    case kReadData: return read_data(out);
    case kReadFaults: return read_faults(view, out);
    case kSession: return change_session(view, out);
    case kReset: return reset(view, out);
    case kTesterPresent: return tester_present(out);
    default: return kServiceUnknown;
  }
}

void UdsServer::tick(Instant now, FrameView rx, const UdsView& view, TxQueue& tx) {
  for (const Frame& frame : rx) {
    if (!transport_.receive(now, frame)) continue;
    const std::uint8_t service = transport_.request()[0];
    Answer answer;
    answer.add(static_cast<std::uint8_t>(service + kPositive));
    std::uint8_t code = serve(view, answer);
    if (answer.too_long) code = kTooLong;
    if (code != 0) {
      const std::uint8_t negative[3] = {kNegative, service, code};
      transport_.respond(negative, sizeof negative);
    } else if (!suppressed(transport_.request())) {
      transport_.respond(answer.bytes, answer.count);
    }
  }
  // Contactors that have closed since it was asked for take the restart back.
  if (!view.may_restart) restart_ = UdsRestart::kNone;
  answered_ = !transport_.sending();
  transport_.tick(now, tx);
}

}  // namespace voltlap::app
