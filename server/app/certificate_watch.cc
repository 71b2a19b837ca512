#include "server/app/certificate_watch.h"

#include <chrono>
#include <mutex>
#include <utility>

namespace kerf::app {
namespace {

constexpr std::int64_t kSecondsOfDay = 86'400;
constexpr std::int64_t kDaysOfNote = 14;
constexpr std::int64_t kMicroseconds = 1'000'000;

// Returns a time as "2027-03-01 12:00:00 UTC".
std::string date_of(std::int64_t unix_s) {
  const auto time = static_cast<std::time_t>(unix_s);
  std::tm parts{};
  char text[40] = {};
  gmtime_r(&time, &parts);
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts);
  return text;
}

}  // namespace

std::optional<std::string> expiry_note(const std::string& option, const std::string& path, std::int64_t end_s,
                                       std::int64_t now_s) {
  const std::string name = option + ": \"" + path + "\" ";
  if (end_s <= now_s) return name + "has expired, at " + date_of(end_s) + "; renew it, then send SIGHUP";
  const std::int64_t days = (end_s - now_s) / kSecondsOfDay;
  if (days >= kDaysOfNote) return std::nullopt;
  return name + "expires in " + std::to_string(days) + (days == 1 ? " day" : " days") + ", at " + date_of(end_s) +
         "; renew it";
}

struct CertificateWatch::State : std::enable_shared_from_this<State> {
  State(host::Clock& its_clock, std::function<void(std::string_view)> its_note)
      : clock(its_clock), note(std::move(its_note)) {}

  void plan() {
    timer = clock.schedule(clock.now() + std::chrono::hours(24), [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->look();
    });
  }
  void look() {
    const std::lock_guard lock(mutex);
    if (is_over) return;
    if (const auto text = expiry_note("--tls-cert", path, end_s, clock.unix_us() / kMicroseconds)) note(*text);
    plan();
  }

  host::Clock& clock;
  const std::function<void(std::string_view)> note;
  std::mutex mutex;  // Guards the members below.
  std::string path;
  std::int64_t end_s = 0;
  std::optional<host::TimerId> timer;
  bool is_over = false;
};

CertificateWatch::CertificateWatch(host::Clock& clock, std::function<void(std::string_view)> note)
    : state_(std::make_shared<State>(clock, std::move(note))) {}

CertificateWatch::~CertificateWatch() {
  const std::lock_guard lock(state_->mutex);
  state_->is_over = true;
  if (state_->timer) state_->clock.cancel(*state_->timer);
}

void CertificateWatch::set(const std::string& path, std::int64_t end_s) {
  const std::lock_guard lock(state_->mutex);
  state_->path = path;
  state_->end_s = end_s;
  if (!state_->timer) state_->plan();
}

std::int64_t CertificateWatch::end_s() const {
  const std::lock_guard lock(state_->mutex);
  return state_->end_s;
}

}  // namespace kerf::app
