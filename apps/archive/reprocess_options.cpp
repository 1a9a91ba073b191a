// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_options.h"

#include "recording/data/error.h"

namespace magimu::apps {

CalibrationOptions ReprocessRowOptions::calibration() const {
  CalibrationOptions out;
  out.noise = noise();
  out.gravity = place_of_field.gravity_or(gravity);
  out.motion = motion_model();
  out.dip_sign = place_of_field.dip_sign();
  const KnownField known = place_of_field.known_field();
  if (known.field) out.initialization.dip_rad = known.field->dip_rad;
  if (mag_time_offset != "auto") out.mag_time_offset = mag_time_offset == "on";
  if (gyro_matrix != "auto") out.gyr_matrix = gyro_matrix == "on";
  out.node_every = node_every;
  return out;
}

ReprocessRowOptions parse_row_options(const std::vector<std::string>& words) {
  ReprocessRowOptions out;
  CLI::App app{"options of one recording"};
  app.set_help_flag();
  add_model_options(app, out);
  add_reading_options(app, out);
  add_place_options(app, out.place_of_field);
  const CLI::IsMember three({"auto", "on", "off"});
  app.add_option("--mag-time-offset", out.mag_time_offset)->check(three);
  app.add_option("--gyro-matrix", out.gyro_matrix)->check(three);
  app.add_option("--node-every", out.node_every)->check(CLI::Range(0, 1000));
  std::vector<std::string> all{"magimu"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : all) argv.push_back(word.data());
  try {
    app.parse(words_of(int(argv.size()), argv.data()));
  } catch (const CLI::ParseError& error) {
    throw InputError("", 0, 0, std::string("its options are not understood: ") + error.what(),
                     "give options of magimu calibrate about reading, model and place "
                     "(magimu calibrate --help)");
  }
  return out;
}

}  // namespace magimu::apps
