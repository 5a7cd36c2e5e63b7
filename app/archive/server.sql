CREATE TABLE IF NOT EXISTS dps_s_facts (
    id      text COLLATE "C" PRIMARY KEY CHECK (id ~ '^[0-9a-f]{40}$'),
    kind    text NOT NULL CHECK (length(kind) <= 40),
    module  text CHECK (length(module) <= 400),
    station text NOT NULL CHECK (length(station) = 64),
    made_at text NOT NULL CHECK (length(made_at) <= 40),
    content text NOT NULL CHECK (octet_length(content) <= 1000000));
REVOKE ALL ON dps_s_facts FROM PUBLIC;
GRANT SELECT, INSERT ON dps_s_facts TO dps_s_station;
