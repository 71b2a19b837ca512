#include "server/service/ws/metrics_page.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <limits>
#include <utility>
#include <vector>

#include "server/base/descriptors.h"
#include "server/base/process_usage.h"
#include "server/service/host/admission.h"

namespace kerf::ws {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

class Page {
 public:
  template <typename Number>
  void counter(std::string name, std::string help, Number value) {
    begin_counter(std::move(name), std::move(help));
    counter_value({}, value);
  }

  void begin_counter(std::string name, std::string help) {
    families_.push_back({std::move(name), std::move(help), MetricType::Counter, {}});
  }

  // Adds another value of the counter begun last.
  template <typename Number>
  void counter_value(std::vector<ClientMetric::Label> labels, Number value) {
    ClientMetric metric;
    metric.label = std::move(labels);
    metric.counter.value = static_cast<double>(value);
    families_.back().metric.push_back(std::move(metric));
  }

  template <typename Number>
  void gauge(std::string name, std::string help, Number value) {
    begin_gauge(std::move(name), std::move(help));
    gauge_value({}, value);
  }

  // Adds another value of the gauge begun last.
  template <typename Number>
  void gauge_value(std::vector<ClientMetric::Label> labels, Number value) {
    ClientMetric metric;
    metric.label = std::move(labels);
    metric.gauge.value = static_cast<double>(value);
    families_.back().metric.push_back(std::move(metric));
  }

  void begin_gauge(std::string name, std::string help) {
    families_.push_back({std::move(name), std::move(help), MetricType::Gauge, {}});
  }

  template <typename Histogram>
  void histogram(std::string name, std::string help, const Histogram& histogram) {
    ClientMetric metric;
    std::uint64_t cumulative = 0;
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
      cumulative += histogram.counts[i];
      const double bound =
          i < Histogram::kBounds.size() ? Histogram::kBounds[i] : std::numeric_limits<double>::infinity();
      metric.histogram.bucket.push_back({cumulative, bound});
    }
    metric.histogram.sample_count = histogram.total;
    metric.histogram.sample_sum = histogram.sum;
    families_.push_back({std::move(name), std::move(help), MetricType::Histogram, {std::move(metric)}});
  }

  [[nodiscard]] std::string text() const { return prometheus::TextSerializer().Serialize(families_); }

 private:
  std::vector<MetricFamily> families_;
};

void add_self_contact(Page& page, const fem::SelfContactStats& counts) {
  page.counter("kerf_self_contact_phases_total", "Times that pairs that may touch were looked at.", counts.phases);
  page.counter("kerf_self_contact_searches_total", "Searches for pairs that may touch.", counts.searches);
  page.counter("kerf_self_contact_contacts_total", "Pairs that pushed each other, in all phases.", counts.contacts);
  page.counter("kerf_self_contact_repairs_total", "Pairs that would have passed through each other and were put back.",
               counts.repairs);
  page.counter("kerf_self_contact_zones_total", "Such pairs that were moved as one with their neighbours.",
               counts.zones);
  page.counter("kerf_self_contact_unsettled_total", "Such pairs that still passed.", counts.unsettled);
  page.counter("kerf_self_contact_intersections_total",
               "Pairs of triangles that passed through each other at the end of a tick, of sheets with self-contact.",
               counts.intersections);
}

void add_host(Page& page, const host::HostMetrics& host) {
  page.counter("kerf_ticks_total", "Ticks stepped, of all sheets.", host.ticks);
  page.counter("kerf_failed_ticks_total", "Ticks whose integrator found no finite step.", host.failed_ticks);
  page.begin_counter("kerf_flagged_ticks_total", "Ticks that reported a flag, such as an unconverged solve.");
  for (std::size_t bit = 0; bit < host.flagged_ticks.size(); ++bit) {
    page.counter_value({{"flag", std::string(fem::kStepFlagNames[bit])}}, host.flagged_ticks[bit]);
  }
  page.counter("kerf_overruns_total", "Ticks that ended after their deadline.", host.overruns);
  page.counter("kerf_slipped_seconds_total", "Simulated time given up because a sheet could not keep pace.",
               host.slipped_s);
  page.counter("kerf_tick_cpu_seconds_total", "CPU time of all ticks.", host.tick_cpu_s);
  page.begin_counter("kerf_tick_part_cpu_seconds_total",
                     "CPU time of ticks without commands, by part, in counted shares.");
  for (std::size_t i = 0; i < host.tick_part_cpu_s.size(); ++i) {
    page.counter_value({{"part", std::string(fem::kTickPartNames[i])}}, host.tick_part_cpu_s[i]);
  }
  page.histogram("kerf_tick_duration_seconds", "Wall time of a tick, publishing included.", host.tick_duration);
  page.counter("kerf_linear_iterations_total", "Iterations of linear solvers.", host.linear_iterations);
  page.histogram("kerf_linear_residual", "Largest true relative residual of the linear solves of a tick.",
                 host.linear_residual);
  page.counter("kerf_snapshots_total", "Snapshots built; none is built unwatched.", host.snapshots);
  page.counter("kerf_contact_phases_total", "Substeps in which colliders were checked.", host.contact_phases);
  add_self_contact(page, host.self_contact);
  page.counter("kerf_cuts_total", "Cuts applied.", host.cuts);
  page.histogram("kerf_cut_duration_seconds", "Wall time of a cut: plan, apply, remesh, model update.",
                 host.cut_duration);
  page.counter("kerf_commands_total", "Commands done, cuts among them.", host.commands);
  page.counter("kerf_commands_refused_total",
               "Commands refused by a full queue, for lack of memory, for an unknown sheet or by the sheet.",
               host.commands_refused);
  page.counter("kerf_sheet_sleeps_total", "Times a sheet fell asleep.", host.sleeps);
  page.counter("kerf_overload_refusals_total", "Sheets that were not created because of the load.",
               host.overload_refusals);
  page.counter("kerf_lost_sheets_total", "Sheets that ended for lack of memory.", host.lost_sheets);
  page.counter("kerf_short_ticks_total", "Ticks that ran out of memory; their sheet is frozen.", host.short_ticks);
  page.gauge("kerf_needed_workers", "Workers that running sheets need; if more than exist, not all sheets keep pace.",
             static_cast<double>(host.worker_need) / static_cast<double>(host::WorkerNeed::kWhole));
  page.begin_gauge("kerf_sheets", "Sheets, by run state.");
  page.gauge_value({{"state", "running"}}, host.running_sheets);
  page.gauge_value({{"state", "paused"}}, host.paused_sheets);
  page.gauge_value({{"state", "sleeping"}}, host.sleeping_sheets);
  page.gauge_value({{"state", "failed"}}, host.failed_sheets);
  page.gauge("kerf_queued_commands", "Commands waiting for a tick boundary.", host.queued_commands);
}

// Adds process metrics under the names used by every Prometheus client library.
void add_process(Page& page) {
  const ProcessUsage usage = own_usage();
  page.gauge("process_open_fds", "Files and connections that the server's process has open.", num_open_descriptors());
  page.counter("process_cpu_seconds_total", "CPU time of the server's process.", usage.cpu_s);
  page.gauge("process_resident_memory_bytes", "Memory of the server's process.", usage.resident_bytes);
}

void add_refusals(Page& page, const std::string& name, std::int64_t in_all, std::int64_t by_address) {
  page.begin_counter(name, "TCP connections refused, by limit: that of all together, or that of one address.");
  page.counter_value({{"limit", "all"}}, in_all);
  page.counter_value({{"limit", "address"}}, by_address);
}

void add_transports(Page& page, const HttpCounts& http, const GrpcCounts& grpc, std::int32_t watchers) {
  page.gauge("kerf_watch_streams", "Watch streams open now, of all transports.", watchers);
  page.counter("kerf_websocket_streams_total", "WebSocket handshakes done.", http.watch_streams);
  page.gauge("kerf_websocket_open_streams", "WebSocket streams open now.", http.open_watch_streams);
  page.counter("kerf_http_connections_total", "TCP connections accepted.", http.connections);
  page.gauge("kerf_http_open_connections", "TCP connections open now.", http.open_connections);
  add_refusals(page, "kerf_http_refused_connections_total", http.refused_connections, http.refused_by_address);
  page.counter("kerf_grpc_connections_total", "TCP connections accepted for gRPC.", grpc.connections);
  page.gauge("kerf_grpc_open_connections", "TCP connections of gRPC open now.", grpc.open_connections);
  add_refusals(page, "kerf_grpc_refused_connections_total", grpc.refused_connections, grpc.refused_by_address);
  page.counter("kerf_http_requests_total", "HTTP requests answered.", http.requests);
  page.counter("kerf_http_failed_requests_total", "HTTP requests answered with a status of 400 or above.",
               http.failed_requests);
}

void add_frames(Page& page, const api::FrameCounts& frames) {
  page.counter("kerf_frames_encoded_total", "Frames encoded; viewers at one rate share one a tick.", frames.encoded);
  page.counter("kerf_frames_sent_total", "Frames sent to streams, of all viewers.", frames.sent);
}

void add_pictures(Page& page, const api::PictureCounts& pictures) {
  page.gauge("kerf_image_streams", "Image streams open now, of all transports.", pictures.streams);
  page.counter("kerf_pictures_rendered_total", "Pictures drawn.", pictures.rendered);
  page.counter("kerf_pictures_encoded_total", "Pictures encoded: JPEG, PNG and frames of VP8.", pictures.encoded);
  page.counter("kerf_pictures_shared_total", "Pictures given to a stream but encoded earlier or for another stream.",
               pictures.shared);
  page.counter("kerf_pictures_sent_total", "Pictures sent to image streams.", pictures.sent);
  page.counter("kerf_pictures_skipped_total", "Ticks skipped by image streams, summed over all streams.",
               pictures.skipped);
}

void add_recordings(Page& page, const RecordingCounts& recordings) {
  page.gauge("kerf_recordings_open", "Recordings to disk of existing sheets, including stopped ones.", recordings.open);
  page.gauge("kerf_recordings_stopped", "Recordings that are stopped because the disk does not accept them.",
             recordings.stopped);
  page.gauge("kerf_recording_waiting_bytes", "Bytes of recordings that wait for the disk.", recordings.waiting_bytes);
  page.counter("kerf_recording_errors_total", "Writes of recordings that failed.", recordings.errors);
  page.counter("kerf_recording_bytes_total", "Bytes of recordings written.", recordings.bytes);
}

}  // namespace

std::string metrics_page(const host::HostMetrics& host, const HttpCounts& http, const GrpcCounts& grpc,
                         std::int32_t watchers, const api::FrameCounts& frames, const api::PictureCounts& pictures,
                         const RecordingCounts& recordings, std::int64_t certificate_end_s,
                         const std::string& version) {
  Page page;
  page.begin_gauge("kerf_build_info", "Always 1; the label is the version.");
  page.gauge_value({{"version", version}}, 1);
  if (certificate_end_s != 0) {
    page.gauge("kerf_certificate_end_unix_seconds", "When the server's certificate ends, in seconds since 1970.",
               static_cast<double>(certificate_end_s));
  }
  add_process(page);
  add_host(page, host);
  add_transports(page, http, grpc, watchers);
  add_frames(page, frames);
  add_pictures(page, pictures);
  add_recordings(page, recordings);
  return page.text();
}

}  // namespace kerf::ws
