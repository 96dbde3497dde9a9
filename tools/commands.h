#pragma once

#include <string_view>

#include "tools/command_line.h"

namespace hapton {

// Every command of the `hapton` program. Each function adds one command to the command line; when the command runs, it sets `exit_code`: 0
// only if it succeeded, otherwise 1 unless the comment below names other codes. RT: no.

// hapton bench [effects|numbers|haptons|objects|papers|pareto|remote|sculpt|sixdof]: run time and error here; without a name: numbers.
void add_bench_command(CommandLine app, int& exit_code);

// hapton check FILE: what is wrong with a scene before anyone touches it. Exit code 0: nothing found, 1: findings, 2: it cannot be checked.
void add_check_command(CommandLine app, int& exit_code);

// hapton dds [--domain N] [--prefix NAME] [--accept-forces N]: shows the device to ROS 2 and other DDS programs. Exit code 0: samples came.
void add_dds_command(CommandLine app, int& exit_code);

// hapton demo [--only N] [--headless --seconds S --out DIR] [--list]: a guided tour that needs no hardware. With --headless: exit code 0
// only if every step showed what it should.
void add_demo_command(CommandLine app, int& exit_code);

// hapton doctor: problems of this machine for haptics, each with the command that fixes it. Exit code 0: none, 1: problems.
void add_doctor_command(CommandLine app, int& exit_code);

// hapton dynamics --scene FILE: lets the stylus push objects that have a mass. Exit code 0: the objects were simulated.
void add_dynamics_command(CommandLine app, int& exit_code);

// hapton echo --bind ADDR:PORT [--seconds N] [--rt MODE]: returns every UDP datagram to its sender as fast as possible.
void add_echo_command(CommandLine app, int& exit_code);

// hapton evaluate --mesh FILE --method proxy: a method's force error against the reference along a generated trajectory. The old name,
// `judge`, still works and says so.
void add_evaluate_command(CommandLine app, int& exit_code);

// hapton figures --out DIR: draws the figures of docs/methods.md with gnuplot.
void add_figures_command(CommandLine app, int& exit_code);

// hapton governor: runs hostile programs against the governor of io_node. Exit code 0 only if every limit held.
void add_governor_command(CommandLine app, int& exit_code);

// hapton info FILE: counts, size and flaws of a mesh, or the objects of a scene.
void add_info_command(CommandLine app, int& exit_code);

// hapton keygen: writes a new key file for nodes on several machines.
void add_keygen_command(CommandLine app, int& exit_code);

// hapton latency [run] [--seconds N] [--rate HZ] [--size B] [--vision] [--out DIR]: starts io_node and haptics_node on this machine beside
// a bare echo and reports the force round trip, its hops, its ratio to the bare echo of the same run and a verdict; with --hosts HUB it
// measures a system that is already running. hapton latency compare A B: two such reports side by side. hapton latency cpus: flags for the
// CPUs on which both nodes reply fastest.
void add_latency_command(CommandLine app, int& exit_code);

// hapton loop zwidth|press|recommend|integrators|velocity|merge: hand, device and force program in closed loop.
void add_loop_command(CommandLine app, int& exit_code);

// hapton mark TEXT [--hub HOST:PORT]: marks the recording of a running session. Exit code 0: it is in the recording.
void add_mark_command(CommandLine app, int& exit_code);

// hapton move OBJECT [--to X,Y,Z] [--rotate X,Y,Z] [--over S]: moves an object of a running scene. Exit code 0: it moves.
void add_move_command(CommandLine app, int& exit_code);

// hapton plot DIR: draws DIR/latency.png from DIR/latency.csv with gnuplot.
void add_plot_command(CommandLine app, int& exit_code);

// hapton relay --hub HOST:PORT [--listen ADDRESS:PORT] [faults | --script FILE]: simulates a bad network between nodes and hub.
void add_relay_command(CommandLine app, int& exit_code);

// hapton replay: runs the haptic step of the live node along a recorded trajectory and writes each step's output.
void add_replay_command(CommandLine app, int& exit_code);

// hapton screen [--hub HOST:PORT | --corners POINTS] [--out FILE]: measures where the screen stands. Exit code 0: FILE was
// written.
void add_screen_command(CommandLine app, int& exit_code);

// hapton sculpt SCENE --annotations FILE --out MESH: writes the carved surface. Exit code 0: MESH was written, 2: it was not.
void add_sculpt_command(CommandLine app, int& exit_code);

// hapton session info|export|replay FILE: works on a recorded session.
void add_session_command(CommandLine app, int& exit_code);

// hapton set --hub HOST:PORT: changes servo rate, force method or materials of a running system, resets faults, requests a report.
void add_set_command(CommandLine app, int& exit_code);

// hapton soak: runs the nodes for hours. Exit code 0: memory, descriptors, threads and losses stayed flat, 1: they did not.
void add_soak_command(CommandLine app, int& exit_code);

// hapton stress --method proxy --steps N --seed S: numerical stress test. Exit code 0 only when no fault was found.
void add_stress_command(CommandLine app, int& exit_code);

// hapton summary DIR [--scene NAME]: what a run touched and whether it held, in two lines. Exit code 0: DIR has a report.
void add_summary_command(CommandLine app, int& exit_code);

// hapton top [--hub HOST:PORT] [--once] [--interval S]: a running system's nodes, rates, latencies and counters, in the terminal.
void add_top_command(CommandLine app, int& exit_code);

// hapton trajectory --mesh FILE --kind slide|free|tap|walk --seed N --out T.csv: generates a trajectory for replay.
void add_trajectory_command(CommandLine app, int& exit_code);

// The subcommands of `hapton bench`.

// hapton bench effects: what each effect adds to the cost of a step.
void add_bench_effects_command(CommandLine bench, int& exit_code);

// hapton bench sixdof: force, torque, gaps and run time of a rigid tool.
void add_bench_sixdof_command(CommandLine bench, int& exit_code);

// hapton bench haptons: how many triangle pairs, colliding on edge and located to 0.1 %, one core processes in a millisecond (HP memo 3.0).
// Exit code 0 only if every pair was located that accurately.
void add_bench_haptons_command(CommandLine bench, int& exit_code);

// hapton bench numbers: measures the project's target numbers in one run, and shows each target beside its measurement.
void add_bench_numbers_command(CommandLine bench, int& exit_code);

// hapton bench objects: what other objects in the scene add to the cost of a step.
void add_bench_objects_command(CommandLine bench, int& exit_code);

// hapton bench papers: the numbers that the HP memo and the FDH paper give for their own systems, measured on this machine. Exit code 0
// only if every requested row was measured.
void add_bench_papers_command(CommandLine bench, int& exit_code);

// hapton bench pareto: run time against force error of every method and structure, with a plot.
void add_bench_pareto_command(CommandLine bench, int& exit_code);

// hapton bench remote: compares ways to touch across a slow network, in simulated time.
void add_bench_remote_command(CommandLine bench, int& exit_code);

// hapton bench sculpt: run time of steps that carve or touch a carved body, and of the surface that is drawn.
void add_bench_sculpt_command(CommandLine bench, int& exit_code);

// The subcommands of `hapton loop`.

// hapton loop integrators --device D: run time against error of the integrator of `hapton loop` and of two usual ones.
void add_loop_integrators_command(CommandLine loop, int& exit_code);

// hapton loop merge PARTS --out FILE: joins the CSV files of all shards of a grid into one.
void add_loop_merge_command(CommandLine loop, int& exit_code);

// hapton loop press --device D --hand H --stiffness K: simulates a press and release and prints its measures.
void add_loop_press_command(CommandLine loop, int& exit_code);

// hapton loop recommend --device D --latency REPORT: the stiffest safe material of this system.
void add_loop_recommend_command(CommandLine loop, int& exit_code);

// hapton loop velocity --device D: velocity estimators compared, noise against lag.
void add_loop_velocity_command(CommandLine loop, int& exit_code);

// hapton loop zwidth --device D --hand H --rate HZ --delay MS [--json]: largest stable and largest passive stiffness and damping.
void add_loop_zwidth_command(CommandLine loop, int& exit_code);

// One command of `hapton`, and the heading of --help under which it is listed.
struct ListedCommand {
  std::string_view group;
  void (*add)(CommandLine app, int& exit_code);
};

// All commands, in the order of --help.
inline constexpr ListedCommand kCommands[] = {
    {"Touch and watch", add_demo_command},
    {"Touch and watch", add_dds_command},
    {"Touch and watch", add_dynamics_command},
    {"Touch and watch", add_info_command},
    {"Touch and watch", add_move_command},
    {"Touch and watch", add_set_command},
    {"Touch and watch", add_top_command},
    {"Set up", add_doctor_command},
    {"Set up", add_keygen_command},
    {"Set up", add_screen_command},
    {"Record and replay", add_mark_command},
    {"Record and replay", add_session_command},
    {"Record and replay", add_trajectory_command},
    {"Record and replay", add_replay_command},
    {"Record and replay", add_sculpt_command},
    {"Measure", add_latency_command},
    {"Measure", add_summary_command},
    {"Measure", add_plot_command},
    {"Measure", add_soak_command},
    {"Measure", add_echo_command},
    {"Measure", add_loop_command},
    {"Compare", add_bench_command},
    {"Compare", add_evaluate_command},
    {"Check", add_check_command},
    {"Check", add_stress_command},
    {"Check", add_governor_command},
    {"Check", add_relay_command},
    {"Develop", add_figures_command},
};

}  // namespace hapton
