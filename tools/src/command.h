#pragma once

namespace CLI {
class App;
}

namespace rubble::tools {

// One function per subcommand of `rubble`: declares its arguments on `app` and what it runs. A run throws
// common::Error for bad input; main turns it into one line on stderr and exit status 1.
void addImportCommand(CLI::App& app);
void addExportCommand(CLI::App& app);
void addReplayCommand(CLI::App& app);
void addPlayCommand(CLI::App& app);
void addEvalCommand(CLI::App& app);
void addEvalMarksCommand(CLI::App& eval);  // Of `rubble eval`.
void addArenaCommand(CLI::App& app);
void addExperimentCommand(CLI::App& app);
void addEmulateCommand(CLI::App& app);
void addEmulateStabilizer(CLI::App& emulate);  // Of `rubble emulate`.
void addDoctorCommand(CLI::App& app);
void addSpyCommand(CLI::App& app);
void addTrainCommand(CLI::App& app);
void addCalibrateCommand(CLI::App& app);

/// A subcommand of `rubble eval`.
void addEvalObjects(CLI::App& parent);

/// Subcommands of `rubble calibrate`.
void addCalibrateCamera(CLI::App& parent);
void addCalibrateExtrinsics(CLI::App& parent);

}  // namespace rubble::tools
