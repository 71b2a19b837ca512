#include <utility>

#include "server/service/host/sheet_runner.h"

// Keeps the changes of a SheetRunner in a journal, and releases what waited until they were durable.
namespace kerf::host {

void SheetRunner::keep_in(Journal& journal, std::int64_t sheet, std::int64_t last_seq) {
  journal_ = SheetJournal(journal, sheet, last_seq, context_.options.encode_event,
                          [weak = weak_from_this(), strand = strand_](std::int64_t seq) {
                            strand.post([weak, seq] {
                              const auto self = weak.lock();
                              if (self) self->keep_or_lose([&] { self->became_durable(seq); });
                            });
                          });
}

void SheetRunner::store_creation(const RequestName<SheetStatus>& request, const SheetStatus& answer) {
  if (!journal_.is_on()) return;
  journal_.create({0, id_, context_.options.encode_scene(sheet_.config()), created_unix_us_,
                   journal_.answered(request, answer)});
  if (clock_.is_paused()) store_run_state();
}

void SheetRunner::store(const SheetEvent& event, std::vector<StoredRequest> requests) {
  if (!journal_.is_on() || closed_ || is_ending_) return;
  journal_.write(event, sheet_.tick(), sheet_.state_hash(), std::move(requests));
}

void SheetRunner::became_durable(std::int64_t seq) {
  if (closed_) return;
  if (auto status = held_status_.take(seq)) last_status_.set(std::move(*status));
  if (auto snapshot = held_snapshot_.take(seq)) sinks_.publish(*snapshot);
  journal_.became_durable(seq);
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
