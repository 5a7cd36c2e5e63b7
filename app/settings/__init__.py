"""Settings as a person edits them: form, drafts, profiles, fingerprint."""
