"""Settings as a person edits them: form, drafts, profiles, consequences, fingerprint."""
