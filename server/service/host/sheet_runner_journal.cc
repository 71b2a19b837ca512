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
  const bool is_idle = context_.stopping || clock_.is_paused() || clock_.is_sleeping();
  const Nanoseconds least = kSavingShare * saving_cpu_;
  const bool may_save = journal_.is_settled() && !closed_ && !is_ending_ && !is_saving_;
  if (!journal_.is_on() || !may_save || !is_unsaved_ || unsaved_cpu_ < least) return;
  // A restart repeats the sheets one after another, so those of a worker share the limit.
  const std::int32_t sheets_a_worker = std::max(context_.board.read().sheets / context_.options.workers, 1);
  if (unsaved_cpu_ < context_.options.max_unsaved_cpu / ((is_idle ? 8 : 1) * sheets_a_worker)) return;
  if (!has_memory_for(kBytesPerSavedVertex * sheet_.mesh().num_vertices())) return;
  const Nanoseconds begin = context_.clock.thread_cpu();
  is_saving_ = true;
  is_unsaved_ = false;
  unsaved_cpu_ = Nanoseconds{0};
  journal_.save(stored(make_state("")), [weak = weak_from_this(), strand = strand_] {
    strand.post([weak] {
      const auto self = weak.lock();
      if (!self) return;
      self->is_saving_ = false;
      self->keep_or_lose([&] { self->save_if_due(); });
    });
  });
  saving_cpu_ = context_.clock.thread_cpu() - begin;
}

StoredState SheetRunner::stored(const SavedState& state) const {
  StoredState stored;
  stored.tick = state.status.tick;
  stored.engine = sheet::read_saved_header(*state.run.sheet).value().engine;
  stored.state_hash = state.status.state_hash;
  stored.continuation_hash = state.status.continuation_hash;
  stored.name = state.status.id;
  stored.content = context_.options.encode_state(state);
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
