// SPDX-License-Identifier: Apache-2.0
#include "pair.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <csetjmp>
#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace same_firmware {
namespace {

// A node that fails jumps back here: firmware has no exceptions.
sigjmp_buf back;
const char* failure = nullptr;

[[noreturn]] void node_failed(const char* condition) {
  failure = condition;
  siglongjmp(back, 1);
}
void on_signal(int number) {
  node_failed(number == SIGFPE ? "that a divisor is not zero" : "that memory is the node's own");
}

const NodeApi* load(const char* file) {
  // RTLD_LOCAL: the two versions have the same names inside.
  void* library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  void* symbol = library == nullptr ? nullptr : dlsym(library, "same_firmware_nodes");
  if (symbol == nullptr) {
    std::fprintf(stderr, "same_firmware: %s\n", dlerror());
    std::exit(2);
  }
  return reinterpret_cast<OpenNodes>(symbol)(node_failed);
}

}  // namespace

Versions load_versions(const char* old_file, const char* present_file) {
  struct sigaction action{};
  action.sa_handler = on_signal;
  action.sa_flags = SA_NODEFER;  // the handler does not return
  sigaction(SIGFPE, &action, nullptr);
  sigaction(SIGSEGV, &action, nullptr);
  return {load(old_file), load(present_file)};
}

bool equal(const Outcome& a, const Outcome& b) {
  if (a.failure != nullptr || b.failure != nullptr) return a.failure != nullptr && b.failure != nullptr;
  return a.count == b.count && std::equal(a.sent, a.sent + a.count, b.sent, [](const WireFrame& x, const WireFrame& y) {
    return x.id == y.id && x.dlc == y.dlc && std::equal(x.data, x.data + 8, y.data);
  });
}

Pair::Pair(const Versions& versions, Which which, const Settings& settings)
    : which_(which), settings_(settings), old_{versions.old_one}, present_{versions.present} {
  start(old_);
  start(present_);
}

Pair::~Pair() {
  stop(old_);
  stop(present_);
}

void Pair::restart() {
  for (Node* node : {&old_, &present_}) {
    stop(*node);
    start(*node);
  }
}

bool Pair::tick(std::uint32_t now_ms, std::span<const WireFrame> rx) {
  step(old_, now_ms, rx);
  step(present_, now_ms, rx);
  return equal(old_.outcome, present_.outcome);
}

void Pair::start(Node& node) {
  node.node = node.api->create(which_, settings_);
  node.outcome.failure = nullptr;
  node.outcome.count = 0;
}

void Pair::stop(Node& node) {
  node.api->destroy(which_, node.node);
  node.node = nullptr;
}

void Pair::step(Node& node, std::uint32_t now_ms, std::span<const WireFrame> rx) const {
  Outcome& out = node.outcome;
  if (out.failure != nullptr) return;
  out.count = 0;
  if (sigsetjmp(back, 0) != 0) {
    out.failure = failure;
    return;
  }
  out.count = node.api->tick(which_, node.node, now_ms, rx.data(), rx.size(), out.sent);
}

}  // namespace same_firmware
