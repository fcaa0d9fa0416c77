// SPDX-License-Identifier: Apache-2.0
#include "apps/child_process.hpp"

#include <fmt/format.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";
constexpr int kCannotStart = 127;
constexpr int kFirstFile = 3, kOutOfTheWay = 64;

/// In the child: these files become 3, 4, ...
void hand_over_files(const std::vector<int>& files) {
  std::vector<int> moved;
  for (const int file : files) moved.push_back(::fcntl(file, F_DUPFD, kOutOfTheWay));
  for (std::size_t i = 0; i < moved.size(); ++i) {
    ::dup2(moved[i], kFirstFile + static_cast<int>(i));
    ::close(moved[i]);
  }
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  if (nothing != STDIN_FILENO) ::close(nothing);
}

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::vector<std::string>& arguments) : name_(std::move(name)) {
  start({kThisProgram, arguments}, "voltlap", SIGTERM);
}

ChildProcess::ChildProcess(std::string name, const ChildProgram& program) : name_(std::move(name)) {
  start(program, program.path, SIGKILL);
}

void ChildProcess::start(const ChildProgram& program, const std::string& called, int end_signal) {
  std::vector<char*> argv = {const_cast<char*>(called.c_str())};
  for (const std::string& a : program.arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw InputError(fmt::format("cannot start a process for {}: {}", name_, std::strerror(errno)));
  if (pid_ > 0) return;
  // A group of its own: Ctrl-C reaches the parent only, which ends the others in their order.
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, end_signal);
  if (::getppid() != parent) ::_exit(kCannotStart);
  if (!program.files.empty()) hand_over_files(program.files);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execv(program.path.c_str(), argv.data());
  ::_exit(kCannotStart);
}

ChildProcess::~ChildProcess() {
  if (!runs()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool ChildProcess::has_just_ended() {
  if (!runs()) return false;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
  status_ = status;
  return true;
}

void ChildProcess::signal(int number) const {
  if (runs()) ::kill(pid_, number);
}

std::optional<int> ChildProcess::exit_code() const {
  return status_ && WIFEXITED(*status_) ? std::optional(WEXITSTATUS(*status_)) : std::nullopt;
}

std::string ChildProcess::end_text() const {
  if (const auto code = exit_code()) return fmt::format("ended with exit code {}", *code);
  const int number = status_ ? WTERMSIG(*status_) : 0;
  return fmt::format("was killed by signal {} ({})", number, ::strsignal(number));
}

}  // namespace voltlap::plant
