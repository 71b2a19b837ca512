#include <algorithm>
#include <utility>

#include "server/base/memory_headroom.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/saved_sheet.h"
#include "server/service/host/sheet_runner.h"

// Keeps the changes of a SheetRunner in a journal, and releases what waited until they were durable.
namespace kerf::host {

namespace {

constexpr int kSavingShare = 20;  // CPU time of ticks over that of saving, at least: large sheets are saved less often.
constexpr int kIdleShare = 64;    // Divides the limit for sheets that are paused or asleep.

}  // namespace

void SheetRunner::keep_in(Journal& journal, std::int64_t sheet, std::int64_t last_seq) {
  journal_ = SheetJournal(journal, sheet, last_seq, context_.options.encode_event,
                          [weak = weak_from_this(), strand = strand_](SheetJournal::Kind kind, std::int64_t number) {
                            strand.post([weak, kind, number] {
                              const auto self = weak.lock();
                              if (self) self->keep_or_lose([&] { self->became_durable(kind, number); });
                            });
                          });
}

void SheetRunner::store_creation(const RequestName<SheetStatus>& request, const SheetStatus& answer) {
  if (!journal_.is_on()) return;
  journal_.create(
      {0, id_, context_.options.encode_scene(sheet_.config()), created_unix_us_, journal_.answered(request, answer)});
  if (clock_.is_paused()) store_run_state();
}

void SheetRunner::store(const SheetEvent& event, std::vector<StoredRequest> requests) {
  if (!journal_.is_on() || closed_ || is_ending_) return;
  journal_.write(event, sheet_.tick(), sheet_.state_hash(), std::move(requests));
}

void SheetRunner::became_durable(SheetJournal::Kind kind, std::int64_t number) {
  if (closed_) return;
  if (kind == SheetJournal::Kind::kNamed) return journal_.named_became_durable(number);
  if (kind == SheetJournal::Kind::kRestore) journal_.restore_became_durable(number);
  if (kind == SheetJournal::Kind::kChange) journal_.became_durable(number);
  if (auto status = held_status_.take(journal_.durable())) last_status_.set(std::move(*status));
  if (auto snapshot = held_snapshot_.take(journal_.durable())) sinks_.publish(*snapshot);
  save_if_due();
}

// Saves the sheet if repeating what it did since the last time would take long. Only between changes that are durable:
// what the attachment holds waits for them.
void SheetRunner::save_if_due() {
  const bool may_save = journal_.is_on() && !closed_ && !is_ending_ && !is_saving_;
  if (!may_save || !is_unsaved_ || !is_save_due() || !journal_.is_settled()) return;
  if (!has_memory_for(kBytesPerSavedVertex * sheet_.mesh().num_vertices())) return;
  const Nanoseconds begin = context_.clock.thread_cpu();
  is_saving_ = true;
  is_unsaved_ = false;
  unsaved_.clear();
  journal_.save(stored(std::make_shared<const SavedState>(make_state(""))),
                [weak = weak_from_this(), strand = strand_] {
                  strand.post([weak] {
                    const auto self = weak.lock();
                    if (!self) return;
                    self->is_saving_ = false;
                    self->keep_or_lose([&] { self->save_if_due(); });
                  });
                });
  saving_cpu_ = context_.clock.thread_cpu() - begin;
}

// A restart repeats the sheets side by side, so all of them share the limits of the workers.
bool SheetRunner::is_save_due() const {
  const HostOptions& options = context_.options;
  const bool is_idle = context_.stopping || clock_.is_paused() || clock_.is_sleeping();
  const Nanoseconds own = unsaved_.value();
  if (own < kSavingShare * saving_cpu_) return false;
  if (own >= options.max_unsaved_cpu / (is_idle ? kIdleShare : 1)) return true;
  return context_.unsaved.total() > options.workers * options.max_unsaved_cpu && own >= context_.unsaved.mean();
}

// The journal encodes the state on a thread of its own.
StoredState SheetRunner::stored(std::shared_ptr<const SavedState> state) const {
  StoredState stored;
  stored.tick = state->status.tick;
  stored.engine = sheet::read_saved_header(*state->run.sheet).value().engine;
  stored.state_hash = state->status.state_hash;
  stored.continuation_hash = state->status.continuation_hash;
  stored.name = state->status.id;
  stored.encode = [encode = context_.options.encode_state, state = std::move(state)] { return encode(*state); };
  return stored;
}

void SheetRunner::remove_from_journal(std::function<void(const Status&)> done) {
  if (!journal_.is_on()) return done(Nothing{});
  stop_clock();
  is_ending_ = true;
  commands_arrived();
  journal_.remove();
  journal_.when_durable(std::move(done));
}

}  // namespace kerf::host
