//! `touchdown settings`.

use touchdown::Result;
use touchdown::settings::defaults;
use touchdown::settings::rig::RigScenario;
use touchdown_campaign::sweep::SweepSettings;
use touchdown_campaign::vertical::scenario::LandScenario;
use touchdown_identify::IdentificationSettings;
use touchdown_link::settings::FlightSettings;
use touchdown_reproduce::settings::ReproduceSettings;

use super::args::{SettingsArgs, SettingsOf};
use super::context::Context;
use touchdown_terminal::Done;

pub(crate) fn run(context: &Context, args: &SettingsArgs) -> Result<Done> {
    if context.wants_json() {
        match args.of {
            SettingsOf::Reproduce => context.object(&ReproduceSettings::default()),
            SettingsOf::Rig => context.object(&RigScenario::default()),
            SettingsOf::Land => context.object(&LandScenario::default()),
            SettingsOf::Campaign => context.object(&SweepSettings::default()),
            SettingsOf::Identify => context.object(&IdentificationSettings::default()),
            SettingsOf::Fly => context.object(&FlightSettings::default()),
        }
    } else {
        let (campaign, fly);
        context.say(match args.of {
            SettingsOf::Reproduce => defaults::REPRODUCE,
            SettingsOf::Rig => defaults::RIG,
            SettingsOf::Land => defaults::LAND,
            SettingsOf::Campaign => {
                campaign = defaults::campaign()?;
                &campaign
            }
            SettingsOf::Identify => defaults::IDENTIFY,
            SettingsOf::Fly => {
                fly = defaults::fly()?;
                &fly
            }
        });
    }
    Ok(Done::Whole)
}
