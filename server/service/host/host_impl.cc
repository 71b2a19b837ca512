#include "server/service/host/host_impl.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "server/base/caught.h"
#include "server/base/interruption.h"
#include "server/base/memory_headroom.h"
#include "server/base/memory_release.h"
#include "server/base/overloaded.h"

namespace kerf::host {

namespace {

// Bytes per vertex while a sheet is being built; up to 6,600 were measured, with a jittered grid of 700 x 700.
constexpr std::int64_t kBytesPerVertex = 8000;
// Number of checks per look at the memory, which costs more than the others.
constexpr int kAskingsToALook = 32;

Error no_sheet(const std::string& id) {
  return not_found("SHEET_NOT_FOUND", "there is no sheet \"" + id + "\"");
}

Error stopping() {
  return unavailable("HOST_STOPPING", "the server is stopping");
}

Error too_many_vertices(std::int64_t count, std::int32_t limit) {
  return resource_exhausted("TOO_MANY_VERTICES", "the sheet has " + std::to_string(count) +
                                                     " vertices; this server's limit is " + std::to_string(limit));
}

// Returns the number of vertices of a config as far as it is known without building.
std::int64_t declared_vertices(const sheet::SheetConfig& config) {
  using Count = std::int64_t;
  return std::visit(Overloaded{
                        [](const sheet::GridSource& grid) { return Count{grid.columns} * grid.rows; },
                        [](const sheet::ObjSource& /*text*/) { return Count{0}; },
                        [](const sheet::PlySource& /*bytes*/) { return Count{0}; },
                        [](const sheet::ArraySource& arrays) { return Count{arrays.num_vertices()}; },
                        [](const sheet::OutlineSource& /*outline*/) { return Count{0}; },
                    },
                    config.mesh);
}

// Reserves the memory that one builder may need, so that another one does not count on it too.
class PromisedBytes {
 public:
  PromisedBytes(std::atomic<std::int64_t>& sum, std::int64_t bytes)
      : sum_(sum), bytes_(bytes), in_all_(sum.fetch_add(bytes) + bytes) {}
  ~PromisedBytes() { sum_ -= bytes_; }
  PromisedBytes(const PromisedBytes&) = delete;
  PromisedBytes& operator=(const PromisedBytes&) = delete;

  // Returns the sum of this promise and those before it.
  [[nodiscard]] std::int64_t in_all() const { return in_all_; }

 private:
  std::atomic<std::int64_t>& sum_;
  const std::int64_t bytes_;
  const std::int64_t in_all_;
};

std::string random_id(std::uint64_t bits) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id = "sheet-";
  for (int i = 0; i < 10; ++i, bits >>= 4U) id += kDigits[bits & 15U];
  return id;
}

}  // namespace

void Host::Impl::create_sheet(std::string id, sheet::SheetConfig config, std::unique_ptr<Playback> playback,
                              bool paused, Callback<SheetStatus> done, const std::stop_token& stop) {
  if (id.empty()) id = config.sheet_id;
  if (id.empty()) id = random_id(entropy_.next());
  // Shared, because posted functions must be copyable. Made first: from here on every failure is answered.
  const auto creation = std::make_shared<Creation>();
  creation->playback = std::move(playback);
  creation->paused = paused;
  creation->done = std::move(done);
  creation->stop = stop;
  const Status queued = caught([&]() -> Status {
    Result<std::shared_ptr<VertexShare>> reserved = reserve(id, config, paused);
    KERF_TRY(reserved);
    creation->vertices = std::move(reserved).value();
    creation->id = std::move(id);
    if (!paused) creation->need = expected_need(config);
    const auto shared = std::make_shared<sheet::SheetConfig>(std::move(config));
    const bool posted = builders_.make_strand().post([this, creation, shared] {
      const Status handed_on = caught([&] { return build_and_hand_on(creation, std::move(*shared)); });
      if (!handed_on.ok()) refuse(*creation, handed_on.error());
    });
    return posted ? Status(Nothing{}) : Status(stopping());
  });
  if (!queued.ok()) refuse(*creation, queued.error());
}

Status Host::Impl::build_and_hand_on(const std::shared_ptr<Creation>& creation, sheet::SheetConfig config) {
  KERF_TRY_ASSIGN(sheet::Sheet built, build(std::move(config), *creation));
  const auto sheet = std::make_shared<sheet::Sheet>(std::move(built));
  const Workers::Strand strand = workers_.make_strand();
  const bool posted = strand.post([this, creation, sheet, strand] {
    const Result<SheetStatus> begun = begin(*creation, std::move(*sheet), strand);
    if (!begun.ok()) return refuse(*creation, begun.error());
    creation->done(*begun);
  });
  return posted ? Status(Nothing{}) : Status(stopping());
}

// Runs on the sheet's strand, before any work that find() could post to it.
Result<SheetStatus> Host::Impl::begin(Creation& creation, sheet::Sheet sheet, const Workers::Strand& strand) {
  const auto runner =
      std::make_shared<SheetRunner>(creation.id, std::move(sheet), context(), strand, creation.vertices);
  const Result<SheetStatus> begun = caught([&]() -> Result<SheetStatus> {
    if (stopping_) return stopping();
    runner->begin(creation.paused, options_.make_recording ? options_.make_recording(creation.id) : nullptr,
                  std::move(creation.playback));
    if (!admit(creation.id, runner)) return stopping();
    creation.need.reset();
    return runner->status();
  });
  if (!begun.ok()) runner->close(stopping_ ? sheet::SinkEnd::kHostStopping : sheet::SinkEnd::kSheetLost);
  return begun;
}

void Host::Impl::refuse(Creation& creation, const Error& error) {
  creation.need.reset();
  if (creation.vertices) {  // Frees the name and the vertices before the answer, so that a retry finds them free.
    creation.vertices->set(0);
    release(creation.id);
  }
  creation.done(error);
}

void Host::Impl::delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed) {
  std::shared_ptr<SheetRunner> runner;
  {
    const std::lock_guard lock(mutex_);
    const auto found = sheets_.find(id);
    if (found != sheets_.end()) runner = std::move(found->second);  // find() does not return it from here on.
  }
  if (!runner) return done(missing(id));
  runner->announce_close();
  runner->post(
      [this, id, done, closed = std::move(closed)](SheetRunner& r) {
        r.close(sheet::SinkEnd::kSheetDeleted);
        const Status ended = caught([&]() -> Status {
          if (closed) closed();
          return Nothing{};
        });
        release(id);
        done(ended);
      },
      done);
}

std::vector<std::string> Host::Impl::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const auto& [id, runner] : sheets_) {
    if (runner) ids.push_back(id);
  }
  return ids;
}

void Host::Impl::stop() {
  std::map<std::string, std::shared_ptr<SheetRunner>> taken;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (release_timer_) clock_.cancel(*release_timer_);
    taken.swap(sheets_);
  }
  for (auto& [id, runner] : taken) {
    if (!runner) continue;  // admit() will refuse it, or its deletion is in progress.
    SheetRunner* const sheet = runner.get();
    // Moves the last reference too, so that the workers destroy sheets in parallel.
    sheet->post([held = std::move(runner)](SheetRunner& r) { r.close(sheet::SinkEnd::kHostStopping); },
                [](const Error&) {});
  }
  workers_.wait_idle();
  has_closed_sheets_ = true;
  builders_.join();  // First, because they post to the workers.
  workers_.join();
}

std::shared_ptr<ExpectedNeed> Host::Impl::expected_need(const sheet::SheetConfig& config) {
  if (!(config.tick_rate_hz > 0.0)) return nullptr;  // Will be refused.
  const Nanoseconds period(std::llround(1.0e9 / config.tick_rate_hz));
  const Nanoseconds tick = WorkerNeed::guessed_tick(declared_vertices(config));
  return std::make_shared<ExpectedNeed>(board_, WorkerNeed(period, tick).value());
}

Result<std::shared_ptr<VertexShare>> Host::Impl::reserve(const std::string& id, const sheet::SheetConfig& config,
                                                         bool paused) {
  if (!sheet::is_valid_sheet_id(id)) {
    return invalid_argument("SHEET_ID", "sheet_id must match [a-z][a-z0-9-]{0,62}", "sheet_id");
  }
  const std::int64_t declared = declared_vertices(config);
  if (declared > options_.max_vertices_per_sheet && declared <= sheet::kMaxVertices) {
    return too_many_vertices(declared, options_.max_vertices_per_sheet);
  }
  const std::lock_guard lock(mutex_);
  if (stopping_) return stopping();
  if (sheets_.contains(id)) {
    return already_exists("SHEET_EXISTS", "a sheet \"" + id + "\" already exists", "sheet_id");
  }
  if (sheets_.size() >= static_cast<std::size_t>(options_.max_sheets)) {
    return resource_exhausted("TOO_MANY_SHEETS", "this server's limit of " + std::to_string(options_.max_sheets) +
                                                     " sheets is reached; delete one");
  }
  // Reserves nothing for a size beyond any sheet's limit, which is refused later. A mesh of unknown size needs some
  // room.
  const std::int64_t taken = declared <= sheet::kMaxVertices ? std::max<std::int64_t>(declared, 1) : 0;
  KERF_TRY(vertices_.take(taken));
  auto share = std::make_shared<VertexShare>(vertices_, taken);
  if (!paused) {
    if (Status s = admission_.admit(load(), options_.workers); !s.ok()) {
      board_.update([](HostMetrics& m) { ++m.overload_refusals; });
      return s.error();
    }
  }
  sheets_.emplace(id, nullptr);
  return share;
}

Result<sheet::Sheet> Host::Impl::build(sheet::SheetConfig config, const Creation& creation) {
  // Stored in the config and so in a recording: a cut refused here is refused in a replay too.
  config.max_vertices = std::min(config.max_vertices, options_.max_vertices_per_sheet);
  const std::int64_t declared = declared_vertices(config);
  const std::int64_t bytes = declared <= sheet::kMaxVertices ? declared * kBytesPerVertex : 0;
  Status wanted = check_wanted(creation);
  KERF_TRY(wanted);
  const PromisedBytes promised(promised_bytes_, bytes);
  if (!has_memory_for(promised.in_all())) return out_of_memory();
  const InterruptionScope scope([&, askings = 0]() mutable {
    wanted = check_wanted(creation);
    const bool looks = askings++ % kAskingsToALook == 0;
    if (wanted.ok() && looks && !has_memory_for(0)) wanted = out_of_memory();
    return wanted.ok();
  });
  Result<sheet::Sheet> built =
      caught([&] { return sheet::Sheet::create(std::move(config), options_.make_integrator); });
  KERF_TRY(wanted);
  KERF_TRY(built);
  KERF_TRY(creation.vertices->settle(built->mesh().num_vertices()));
  if (!has_memory_for(0)) return out_of_memory();
  KERF_TRY(check_wanted(creation));
  return built;
}

Status Host::Impl::check_wanted(const Creation& creation) const {
  if (stopping_) return stopping();
  if (creation.stop.stop_requested()) {
    return aborted("CREATION_ABANDONED", "the client left before its sheet was built; request it again");
  }
  return Nothing{};
}

void Host::Impl::release(const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    sheets_.erase(id);
  }
  try {
    plan_to_release_memory();
  } catch (const std::bad_alloc&) {  // The next sheet that ends tries again.
  }
}

void Host::Impl::plan_to_release_memory() {
  const auto give_back = [this, strand = workers_.make_strand()] {
    strand.post([this] {
      {
        const std::lock_guard lock(mutex_);
        release_timer_.reset();
      }
      release_free_memory();
    });
  };
  const std::lock_guard lock(mutex_);
  if (stopping_ || release_timer_) return;
  release_timer_ = clock_.schedule(clock_.now() + kReleaseDelay, give_back);
}

bool Host::Impl::admit(const std::string& id, const std::shared_ptr<SheetRunner>& runner) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return false;
  sheets_[id] = runner;
  return true;
}

std::shared_ptr<SheetRunner> Host::Impl::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = sheets_.find(id);
  return found == sheets_.end() ? nullptr : found->second;
}

Error Host::Impl::missing(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  return stopping_ ? stopping() : no_sheet(id);
}

void Host::Impl::status(const std::string& id, const Callback<SheetStatus>& done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  if (runner->is_at_long_tick()) return done(*runner->last_status());
  runner->post([done](SheetRunner& r) { done(r.status()); }, [done](Error error) { done(std::move(error)); });
}

void Host::Impl::pause(const std::string& id, const Callback<SheetStatus>& done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  runner->post_pause(done);
}

std::vector<SheetStatus> Host::Impl::statuses(const std::vector<std::string>& ids) const {
  std::vector<SheetStatus> found;
  for (const std::string& id : ids) {
    if (const std::shared_ptr<SheetRunner> runner = find(id)) found.push_back(*runner->last_status());
  }
  return found;
}

void Host::Impl::submit(const std::string& id, sheet::Command command, Callback<CommandResult> done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  const Status accepted = runner ? runner->enqueue(std::move(command), done) : Status(missing(id));
  if (accepted.ok()) return;
  board_.update([](HostMetrics& m) { ++m.commands_refused; });
  done(accepted.error());
}

void Host::Impl::schedule(const std::string& id, sheet::Command command, std::int64_t at_tick,
                          const Callback<std::int64_t>& done) {
  const auto answer = [this, done](Result<std::int64_t> number) {
    if (!number.ok()) board_.update([](HostMetrics& m) { ++m.commands_refused; });
    done(std::move(number));
  };
  on_strand<std::int64_t>(id, answer, [command = std::move(command), at_tick, answer](SheetRunner& r) mutable {
    answer(r.schedule(std::move(command), at_tick));
  });
}

}  // namespace kerf::host
