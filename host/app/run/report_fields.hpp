#pragma once

#include "host/app/run/json_archive.hpp"
#include "weft/report.hpp"

// The keys of reports and their lines.
namespace weft::app {

inline void fields(JsonArchive& io, StageTimes& s) {
  io.ms("contacts", s.contacts);
  io.ms("assemble", s.assemble);
  io.ms("solve", s.solve);
  io.ms("resolve_collisions", s.resolve_collisions);
  io.ms("other", s.other);
}

inline void fields(JsonArchive& io, CollisionTimes& c) {
  io.ms("detection", c.detection);
  io.ms("searches", c.searches);
  io.ms("solves", c.solves);
  io.ms("zones", c.zones);
}

inline void fields(JsonArchive& io, AsynchronousCounts& c) {
  io("windows", c.windows);
  io("clean_windows", c.clean_windows);
  io("rollbacks", c.rollbacks);
  io("window_s", c.window_length);
  io("ahead_started", c.ahead_started);
  io("ahead_accepted", c.ahead_accepted);
  io("ahead_cancelled", c.ahead_cancelled);
  io("ahead_held", c.ahead_held);
  io("ticks", c.ticks);
  io("elements", c.elements);
  io("layer_pairs", c.layer_pairs);
  io("acting_pairs", c.acting_pairs);
  io("resimulated", c.resimulated);
  io("layers_added", c.layers_added);
  io("candidates", c.candidates);
  io("slabs", c.slabs);
  io("failsafe", c.failsafe);
  io("ccd_tests", c.ccd_tests);
  io("pairs_max", c.pairs_max);
  io("layers_max", c.layers_max);
  io.ms("useful_ms", c.useful);
  io.ms("resimulation_ms", c.resimulation);
  io.ms("detection_ms", c.detection);
  io.ms("unneeded_ms", c.unneeded);
  io.ms("bookkeeping_ms", c.bookkeeping);
  io.ms("beside_detection_ms", c.beside_detection);
}

inline void fields(JsonArchive& io, RemeshReport& r) {
  io("splits", r.splits);
  io("flips", r.flips);
  io("collapses", r.collapses);
  io("refused", r.refused);
  io("redone", r.redone);
  io("vertices", r.vertices);
  io("triangles", r.triangles);
  io("energy_jump", r.energy_jump);
  io.ms("ms", r.seconds);
  io.ms("rebuild_ms", r.rebuild_seconds);
  io.ms("cpu_ms", r.cpu_seconds);
  io.only_if(r.factor_mean > 0, "in_view", r.in_view);
  io.only_if(r.factor_mean > 0, "factor_mean", r.factor_mean);
  io.only_if(r.factor_mean > 0, "compression_jump", r.compression_jump);
}

inline void fields(JsonArchive& io, SleepReport& r) {
  io("pieces", r.pieces);
  io("asleep", r.asleep);
  io("fell_asleep", r.fell_asleep);
  io("woken", r.woken);
  io("redone", r.redone);
  io("departure", r.departure);
}

inline void fields(JsonArchive& io, SharedWork& work) {
  io("busiest", work.busiest);
  io("even", work.even);
  io.derived("imbalance", work.imbalance());
}

inline void fields(JsonArchive& io, BalanceReport& b) {
  io("rows_bytes", b.rows);
  io("box_tests", b.box_tests);
  io("pairs", b.pairs);
  io("ccd_tests", b.ccd_tests);
  io("queries", b.queries);
  io("rebalances", b.rebalances);
  io.ms("ms", b.seconds);
  io.if_known(b.rebalances > 0, "imbalance_before", b.imbalance_before);
  io.if_known(b.rebalances > 0, "imbalance_after", b.imbalance_after);
}

inline void fields(JsonArchive& io, Energy& energy) {
  io("kinetic", energy.kinetic);
  io("elastic", energy.elastic);
  io("gravitational", energy.gravitational);
}

}  // namespace weft::app
